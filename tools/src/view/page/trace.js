// Figure 6 of the paper: how excited the learner is, and what by.

import { byId, draw, level, whole } from "./dom.js";
import { moment } from "./ask.js";

const KEPT_MAX = 2000;
/** A page that is further behind than this begins anew: the learner is faster than it. */
const BEHIND_MAX = 4000;
const TO = byId("trace");
const span = byId("span");

/** Records that come at a time: with as many left, the learner is faster than is asked. */
const PAGE = 256;

let records = [];
let next = null;

/** The number of the first record that is wanted. Before anything is known, none: only how many there are. */
export const wantedFrom = () => next ?? Number.MAX_SAFE_INTEGER;

/** Takes what came; says whether there is more to be had at once. */
export function take(trace) {
  if (next === null || trace.total < next || trace.total - next > BEHIND_MAX) {
    next = Math.max(0, trace.total - KEPT_MAX);
    records = [];
    return trace.total > next;
  }
  // Asked for twice, it comes twice.
  if (trace.from < next) return false;
  records.push(...trace.records.map(point));
  records = records.slice(-KEPT_MAX);
  next = trace.from + trace.records.length;
  return trace.total - next >= PAGE;
}

/** The paper's touch sensor; other bodies have other senses, and then nothing is marked. */
const TOUCH = "touch";

/** What the curve needs of a step. */
function point({ step, stage, decision, perceived, heard }) {
  return {
    step,
    stage,
    top: decision?.excitation_top ?? null,
    touching: decision?.predicts.includes(TOUCH) ?? false,
    touched: perceived.some((one) => one.type === TOUCH),
    heard,
  };
}

/** The daemon is another: its steps are others. */
export function forget() {
  next = null;
}

/** Draws what there is. */
export function show() {
  const decided = decisions().slice(-Number(span.value));
  const width = Math.max(320, Math.round(TO.clientWidth));
  if (decided.length < 2) {
    TO.replaceChildren(nothing(width));
    return;
  }
  TO.replaceChildren(figure(decided, width));
}

/** The steps that decided something; what was felt and heard in others belongs to the one before. */
function decisions() {
  const decided = [];
  for (const record of records) {
    const before = decided[decided.length - 1];
    if (record.top !== null) decided.push({ ...record });
    else if (before !== undefined) {
      before.touched ||= record.touched;
      before.heard = [...before.heard, ...record.heard];
    }
  }
  return decided;
}

function nothing(width) {
  const text = moment.until === null ? "No decision yet" : "The curve is of the present only";
  return draw("svg", { class: "trace", viewBox: `0 0 ${width} 270`, role: "img", "aria-label": text },
    draw("text", { x: width / 2, y: 130, class: "middle tick" }, text));
}

function figure(decided, width) {
  const upper = { left: 52, right: width - 8, top: 40, bottom: 186 };
  const lower = { top: 200, bottom: 230 };
  const highest = Math.max(...decided.map((record) => record.top), 1e-9) * 1.08;
  const x = (at) => upper.left + (at / (decided.length - 1)) * (upper.right - upper.left);
  const y = (value) => upper.bottom - (value / highest) * (upper.bottom - upper.top);
  const line = decided.map((record, at) => `${at === 0 ? "M" : "L"}${x(at).toFixed(1)} ${y(record.top).toFixed(1)}`);
  const low = (record) => (record.touching ? lower.top + 5 : lower.bottom - 5);
  const states = decided.map((record, at) => (at === 0 ? `M${x(0)} ${low(record)}` : `H${x(at).toFixed(1)}V${low(record)}`));
  const last = decided[decided.length - 1];
  const label = `Excitation over steps ${decided[0].step} to ${last.step}, now ${level(last.top)}`;
  return draw("svg", { class: "trace", viewBox: `0 0 ${width} 270`, role: "img", "aria-label": label },
    draw("text", { x: 2, y: 12 }, "excitation of the most excited schema"),
    ticks(highest).map((value) => [
      draw("line", { class: "grid", x1: upper.left, x2: upper.right, y1: y(value), y2: y(value) }),
      draw("text", { class: "tick end", x: upper.left - 6, y: y(value) + 4 }, String(value)),
    ]),
    draw("path", { class: "curve c0", d: line.join("") }),
    events(decided, x, upper),
    draw("text", { class: "tick end", x: upper.left - 6, y: lower.top + 9 }, "touch"),
    draw("text", { class: "tick end", x: upper.left - 6, y: lower.bottom - 1 }, "other"),
    draw("path", { class: "curve c1", d: states.join("") }),
    cursor(decided, x, upper.top, lower.bottom),
    axis(decided, x, lower.bottom + 4, width));
}

/** Room for a word, about, so that none is written over another. */
const WORD_PX = 64;

function events(decided, x, frame) {
  const marks = [];
  let written = -Infinity;
  decided.forEach((record, number) => {
    const at = x(number);
    if (record.touched) marks.push(draw("circle", { class: "mark touched", cx: at, cy: frame.bottom - 3, r: 2.2 }));
    if (record.heard.length === 0) return;
    const heard = record.heard.join(" ");
    const place = `M${at - 5} ${frame.top - 7}H${at + 5}L${at} ${frame.top + 2}Z`;
    marks.push(draw("path", { class: "mark word", d: place }, draw("title", {}, heard)));
    if (at - written < WORD_PX) return;
    written = at;
    marks.push(draw("text", { class: "middle", x: Math.min(at, frame.right - 20), y: frame.top - 9 }, heard));
  });
  return marks;
}

function cursor(decided, x, top, bottom) {
  const at = decided.findIndex((record) => record.step >= (moment.until ?? Infinity));
  return at < 0 ? null : draw("line", { class: "cursor", x1: x(at), x2: x(at), y1: top, y2: bottom });
}

function axis(decided, x, y, width) {
  const count = width < 500 ? 3 : 6;
  const places = Array.from({ length: count }, (_, at) => Math.round((at * (decided.length - 1)) / (count - 1)));
  return [
    draw("line", { class: "axis", x1: x(0), x2: x(decided.length - 1), y1: y, y2: y }),
    places.map((at, number) => draw("text", {
      class: number === 0 ? "tick" : number === count - 1 ? "tick end" : "tick middle", x: x(at), y: y + 16,
    }, whole(decided[at].step))),
    draw("text", { class: "middle", x: (x(0) + x(decided.length - 1)) / 2, y: y + 32 }, "step"),
  ];
}

/** Round values from 0 to the highest. */
function ticks(highest) {
  const rough = highest / 4;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((factor) => factor * power).find((wide) => wide >= rough);
  const digits = Math.max(0, -Math.floor(Math.log10(step)));
  return Array.from({ length: Math.floor(highest / step) + 1 }, (_, at) => Number((at * step).toFixed(digits)));
}

span.addEventListener("change", show);
new ResizeObserver(show).observe(TO);
