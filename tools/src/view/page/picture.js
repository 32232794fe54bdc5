// The camera's picture as it comes, with its fields and what was perceived in them.

import { byId, tell } from "./dom.js";
import { moment } from "./ask.js";

const picture = byId("picture");
const marks = byId("marks");
const rate = byId("rate");
const numbers = byId("numbers");

let fields = { version: 0, fields: [] };
let perceived = [];
let frames = 0;
let since = performance.now();
/** Pictures shown since the page was opened, for who measures. */
document.documentElement.dataset.frames = "0";

const COLOURS = { finger: "#1f9d55", object: "#d97706", touch: "#c2185b" };

/** Shows where the things perceived are. */
export function showPerceived(world) {
  perceived = world.map((one) => one.observation);
  const places = perceived.map((one) => named(one)).join(", ");
  marks.setAttribute("aria-label", places === "" ? "Nothing is perceived" : `Perceived: ${places}`);
  drawMarks();
}

/** Shows that no picture is of the moment looked at. */
export function noPicture(why) {
  picture.getContext("2d").clearRect(0, 0, picture.width, picture.height);
  tell(rate, why);
  drawMarks();
}

/** Asks for one picture after the other, for ever: the next when the last is shown. */
export async function watchPictures() {
  let after = 0;
  for (;;) {
    if (document.hidden || moment.until !== null) {
      await pause(250);
      continue;
    }
    const shown = await next(after).catch(() => null);
    if (shown === null) {
      if (moment.until === null) noPicture("no pictures: no body that takes any is acting");
      await pause(500);
    } else {
      after = shown;
    }
  }
}

async function next(after) {
  const reply = await fetch(`./picture?after=${after}`);
  if (reply.status !== 200) return null;
  const image = await createImageBitmap(await reply.blob());
  if (Number(reply.headers.get("fields")) !== fields.version) await takeFields();
  if (moment.until === null) {
    resize(image.width, image.height);
    picture.getContext("2d").drawImage(image, 0, 0);
    count();
  }
  image.close();
  return Number(reply.headers.get("picture"));
}

async function takeFields() {
  const reply = await fetch("./fields");
  if (reply.status === 200) fields = await reply.json();
  drawMarks();
}

function resize(width, height) {
  if (picture.width === width && picture.height === height) return;
  for (const canvas of [picture, marks]) {
    canvas.width = width;
    canvas.height = height;
  }
  drawMarks();
}

function count() {
  frames += 1;
  document.documentElement.dataset.frames = String(Number(document.documentElement.dataset.frames) + 1);
  const now = performance.now();
  if (now - since >= 1000) {
    tell(rate, `${((frames * 1000) / (now - since)).toFixed(0)} pictures/s`);
    frames = 0;
    since = now;
  }
}

function property(observation, name) {
  return observation.properties[name];
}

function named(observation) {
  const colour = property(observation, "colour");
  const field = property(observation, "field");
  const name = typeof colour === "string" ? `${colour} ${observation.type}` : observation.type;
  return Number.isInteger(field) ? `${name} in field ${field}` : name;
}

function drawMarks() {
  const to = marks.getContext("2d");
  to.clearRect(0, 0, marks.width, marks.height);
  // As large as on paper, however small the picture is shown.
  const scale = Math.min(1, marks.clientWidth / marks.width || 1);
  to.font = "11px system-ui, sans-serif";
  to.textAlign = "center";
  to.textBaseline = "middle";
  to.lineWidth = 1;
  fields.fields.forEach(([x, y, radius], number) => {
    to.strokeStyle = "rgba(20, 24, 30, 0.35)";
    circle(to, x, y, radius);
    if (numbers.checked && radius * scale >= 12) outlined(to, String(number), x, y);
  });
  const touches = perceived.some((one) => one.type === "touch");
  const drawn = new Map();
  for (const one of perceived) {
    const field = property(one, "field");
    const mark = fields.fields[field];
    if (!Number.isInteger(field) || mark === undefined) continue;
    const [x, y, radius] = mark;
    const inside = drawn.get(field) ?? 0;
    drawn.set(field, inside + 1);
    to.lineWidth = 3 / scale;
    to.strokeStyle = touches && one.type === "finger" ? COLOURS.touch : (COLOURS[one.type] ?? "#0072b2");
    circle(to, x, y, radius + inside * 4);
    to.font = `600 ${13 / scale}px system-ui, sans-serif`;
    const label = touches && one.type === "finger" ? "finger touches" : named(one).replace(/ in field .*/, "");
    const place = Math.min(Math.max(x, 50 / scale), marks.width - 50 / scale);
    const away = radius + (9 + inside * 15) / scale;
    outlined(to, label, place, y - away < 8 / scale ? y + away : y - away);
  }
}

function circle(to, x, y, radius) {
  to.beginPath();
  to.arc(x, y, radius, 0, 2 * Math.PI);
  to.stroke();
}

function outlined(to, text, x, y) {
  to.save();
  to.lineWidth = 3;
  to.lineJoin = "round";
  to.strokeStyle = "rgba(255, 255, 255, 0.85)";
  to.fillStyle = "#14171b";
  to.strokeText(text, x, y);
  to.fillText(text, x, y);
  to.restore();
}

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
numbers.addEventListener("change", drawMarks);
new ResizeObserver(drawMarks).observe(marks);
