// The list of schemas, and one of them whole. The daemon filters, sorts and pages.

import { ask, turns } from "./ask.js";
import { byId, el, notation, observation, share, tell, whole } from "./dom.js";

const PAGE = 20;
const form = byId("filter");
const listTurn = turns();
const oneTurn = turns();
const whyTurn = turns();
let offset = 0;
/** The schema that is shown, or is about to be. */
let wantedOne = null;
let onGraph = () => {};

/** Begins; `graph` is called with a schema whose graph is wanted. */
export function begin(graph) {
  onGraph = graph;
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    list(0);
  });
  form.addEventListener("change", () => list(0));
  byId("earlier").addEventListener("click", () => list(Math.max(0, offset - PAGE)));
  byId("later").addEventListener("click", () => list(offset + PAGE));
}

/** Lists the page that begins after so many. */
export async function list(from = offset) {
  const wanted = new FormData(form);
  const given = (name) => String(wanted.get(name) ?? "").trim() || null;
  const isWanted = listTurn();
  try {
    const answer = await ask({
      ask: "schemas", action: given("action"), pre: given("pre"), post: given("post"),
      generalised: wanted.has("generalised"), sort: given("sort") ?? "age", limit: PAGE, offset: from,
    });
    if (!isWanted()) return;
    offset = from;
    showList(answer);
  } catch (trouble) {
    if (isWanted()) tell(byId("schemas-note"), trouble.message);
  }
}

function showList(answer) {
  const { matching, schemas } = answer;
  const last = offset + schemas.length;
  tell(byId("schemas-note"), matching === 0 ? "No schema is like that." : `${whole(matching)} fit.`);
  tell(byId("page"), matching === 0 ? "" : `${whole(offset + 1)} to ${whole(last)} of ${whole(matching)}`);
  byId("earlier").disabled = offset === 0;
  byId("later").disabled = last >= matching;
  byId("list").replaceChildren(...schemas.map((schema) => el("tr", {},
    el("td", { class: "n" }, opener(schema.id)),
    el("td", {}, schema.kind),
    el("td", { class: "code" }, notation(schema)),
    el("td", { class: "n" }, whole(schema.executions)),
    el("td", { class: "n" }, schema.executions === 0 ? "–" : share(schema.probability)))));
}

function opener(id) {
  return el("button", { type: "button", class: "id", "aria-label": `Show schema ${id}`, onclick: () => showOne(id) }, String(id));
}

/** The newest, as they come. */
export function showNewest(schemas) {
  byId("newest").replaceChildren(...schemas.map((schema) =>
    el("li", {}, opener(schema.id), el("span", { class: "code" }, notation(schema)))));
}

/** Shows one schema whole. */
export async function showOne(id, quiet = false) {
  const panel = byId("one");
  const isWanted = oneTurn();
  wantedOne = id;
  let parts;
  try {
    parts = one(await ask({ ask: "show", id }));
  } catch (trouble) {
    parts = [el("p", {}, trouble.message)];
  }
  if (!isWanted()) return;
  byId("whole").replaceChildren(...parts);
  tell(byId("one-title"), `Schema ${id}`);
  panel.hidden = false;
  if (!quiet) panel.focus();
}

/** The schema that is shown or about to be, if one is. */
export const shownOne = () => wantedOne;

function one(schema) {
  const reasons = el("div", {});
  return [
    el("p", {}, schema.sentence),
    el("p", { class: "code" }, schema.notation),
    el("p", { class: "facts" }, `${schema.kind}; made in step ${whole(schema.created_step)}; `
      + (schema.executions === 0 ? "not tried yet" : `succeeded in ${whole(schema.successes)} of ${whole(schema.executions)}: `
      + `${share(schema.probability)} (${share(schema.low)} to ${share(schema.high)})`)),
    conditions("Post-conditions", schema.post),
    schema.associated.length === 0 ? null : conditions("Associated observations", schema.associated),
    schema.rests_on === "" ? null : el("div", {}, el("h3", {}, "Claims that it rests on"), el("pre", {}, schema.rests_on)),
    related("Parent", schema.parent === null ? [] : [schema.parent]),
    related("Counter-example to", schema.contradicts === null ? [] : [schema.contradicts]),
    related(schema.kind === "generalised" ? "Examples" : "Example of", schema.examples),
    related("Counter-examples", schema.counter_examples),
    el("p", {},
      el("button", { type: "button", onclick: () => whyNot(schema.id, reasons) }, "Why was it not chosen?"), " ",
      el("button", { type: "button", onclick: () => onGraph(schema.id) }, "Graph around it")),
    reasons,
  ].filter((part) => part !== null);
}

function conditions(title, list) {
  const rows = list.map((one) => el("tr", {},
    el("td", { class: "code" }, (one.absent ? "no longer " : "") + observation(one.observation)),
    el("td", { class: "n" }, `${whole(one.occurrences)}/${whole(one.trials)}`),
    el("td", { class: "n" }, one.trials === 0 ? "–" : share(one.probability)),
    el("td", {}, one.trials === 0 ? "" : interval(one))));
  return el("div", { class: "scroll" }, el("h3", {}, title), el("table", {},
    el("thead", {}, el("tr", {}, el("th", {}, "observation"), el("th", { class: "n" }, "held"),
      el("th", { class: "n" }, "probability"), el("th", {}, "95 % interval"))),
    el("tbody", {}, rows)));
}

function interval(one) {
  const bar = el("div", { class: "interval", role: "img", "aria-label": `${share(one.low)} to ${share(one.high)}` });
  const range = el("i");
  range.style.left = `${one.low * 100}%`;
  range.style.width = `${(one.high - one.low) * 100}%`;
  const middle = el("b");
  middle.style.left = `${Math.min(one.probability * 100, 98.5)}%`;
  bar.append(range, middle);
  return bar;
}

function related(title, ids) {
  if (ids.length === 0) return null;
  const SHOWN = 40;
  return el("p", {}, `${title}: `, ids.slice(0, SHOWN).map((id) => [opener(id), " "]),
    ids.length > SHOWN ? `and ${whole(ids.length - SHOWN)} more` : "");
}

async function whyNot(id, to) {
  const isWanted = whyTurn();
  let told;
  try {
    told = el("pre", {}, (await ask({ ask: "why-not", id })).text);
  } catch (trouble) {
    told = el("p", {}, trouble.message);
  }
  if (isWanted()) to.replaceChildren(told);
}

