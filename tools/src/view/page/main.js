// The page: what is shown when, and what is ordered.

import { ask, askNow, moment } from "./ask.js";
import { byId, el, isBeingRead, tell, whole } from "./dom.js";
import * as claims from "./claims.js";
import { showDecision } from "./decision.js";
import { showFacts } from "./facts.js";
import * as graph from "./graph.js";
import { noPicture, showPerceived, watchPictures } from "./picture.js";
import * as schemas from "./schemas.js";
import * as trace from "./trace.js";

const LIVE_EVERY_MS = 200;
const TRY_AGAIN_AFTER_MS = 1000;
const LIST_EVERY_MS = 3000;
/** The list is sorted anew no oftener than takes a twentieth of the time: in a large memory that is a lot of work. */
const LIST_SHARE = 20;

/** How often more of the curve is asked for before the page is drawn all the same. */
const BEHIND_IN_A_ROW = 12;

let behind = 0;
let about = null;
let now = null;
let listNext = 0;
/** What of the present is shown: nothing is drawn again that is the same. */
let shownStep = null;
let shownState = null;

/** What went wrong, until it is well again. */
function banner(text) {
  byId("banner").hidden = text === null;
  if (text !== null) tell(byId("banner"), text);
}

/** Everything that is of one moment. */
function showMoment(live, past) {
  if (!past && live.step === shownStep && live.stage_state === shownState) return;
  [shownStep, shownState] = past ? [null, null] : [live.step, live.stage_state];
  const perceived = live.observations;
  tell(byId("world-note"), perceived.length === 0 ? "Nothing is perceived."
    : past ? "As last perceived. N: how often each has had attention."
      : "New observations are marked. N: how often each has had attention.");
  byId("world").replaceChildren(...perceived.map((one, at) => el("li", { class: one.new && !past ? "new" : "" },
    el("span", { class: "code" }, live.world[at]),
    one.new && !past ? el("span", { class: "badge" }, "new") : null,
    el("span", { class: "n" }, `N ${whole(one.attention)}`))));
  showPerceived(perceived);
  showDecision(live, past, schemas.showOne);
  if (!isBeingRead(byId("newest"))) schemas.showNewest(live.newest);
  showFacts(live, past);
}

function showHeader(live) {
  tell(byId("name"), live.name);
  document.title = `${live.name}: pschema view`;
  const speed = about.live ? `, ${live.steps_per_s.toFixed(0)} steps/s` : "";
  tell(byId("state"), `${live.stage}: ${live.stage_state} · step ${whole(live.step)}${speed} · ${whole(live.schemas_total)} schemas, ${whole(live.schemas_generalised)} generalised · profile ${live.profile}`);
  byId("state").dataset.step = String(live.step);
  const held = live.stage_state === "held";
  byId("hold").disabled = held;
  byId("resume").disabled = !held;
}

/** Follows the learner for ever. */
async function follow() {
  for (;;) {
    let wait = LIVE_EVERY_MS;
    try {
      if (about === null) await begin();
      if (!document.hidden && about.live) wait = await look();
      banner(null);
    } catch (trouble) {
      wait = TRY_AGAIN_AFTER_MS;
      if (about?.live && trouble.noDaemon) trace.forget();
      if (about === null || about.live) banner(`${trouble.message}${trouble.noDaemon ? " This page goes on when it is back." : ""}`);
      if (about?.live && trouble.noDaemon) about = { ...about, stale: true };
    }
    await new Promise((resolve) => setTimeout(resolve, wait));
  }
}

/** Asks which learner this is. */
async function begin() {
  about = await askNow({ ask: "about" });
  const kept = about.directory !== null;
  byId("time").hidden = !kept;
  byId("controls").hidden = !about.live;
  if (kept) setRange(about.oldest_step ?? 0, about.last_step ?? 0);
  if (!about.live) {
    byId("present").hidden = true;
    await lookBack(about.last_step);
  }
  schemas.list(0);
}

async function look() {
  const live = await askNow({ ask: "live", trace_from: trace.wantedFrom() });
  if (about.stale) about = await askNow({ ask: "about" });
  now = live;
  // The curve is caught up with before anything is drawn: drawing takes the time.
  if (trace.take(live.trace) && (behind += 1) <= BEHIND_IN_A_ROW) return LIVE_EVERY_MS / 4;
  behind = 0;
  trace.show();
  showHeader(live);
  if (live.durable_step !== null) setRange(null, live.durable_step);
  if (moment.until === null) {
    showMoment(live, false);
    if (performance.now() >= listNext && !isBeingRead(byId("schemas"))) relist();
  }
  return LIVE_EVERY_MS;
}

async function relist() {
  listNext = Infinity;
  const begun = performance.now();
  await schemas.list();
  const ended = performance.now();
  listNext = ended + Math.max(LIST_EVERY_MS, (ended - begun) * LIST_SHARE);
}

function setRange(oldest, last) {
  for (const input of [byId("slider"), byId("until")]) {
    if (oldest !== null) input.min = String(oldest);
    if (input.max !== String(last)) input.max = String(last);
    if (moment.until === null && document.activeElement !== input) input.value = String(last);
  }
}

let wanted = null;
let looking = false;

/** Shows memory as it was after a step; of many that are wanted in a row, the last. */
async function lookBack(step) {
  wanted = step;
  if (looking) return;
  looking = true;
  while (wanted !== null) {
    const until = wanted;
    wanted = null;
    await showPast(until);
  }
  looking = false;
}

async function showPast(until) {
  moment.until = until;
  document.body.classList.add("past");
  byId("present").setAttribute("aria-pressed", "false");
  byId("slider").value = String(until);
  byId("until").value = String(until);
  tell(byId("when"), `Rebuilding memory as it was after step ${whole(until)}…`);
  noPicture("pictures are not kept: the fields, with what was perceived in them");
  try {
    const live = await ask({ ask: "live", trace_from: 0 });
    if (moment.until !== until) return;
    showMoment(live, true);
    if (!about.live) showHeader(live);
    trace.show();
    document.body.dataset.shown = String(live.step);
    await renewRest();
    if (moment.until !== until) return;
    tell(byId("when"), `Memory as it was after step ${whole(live.step)}, rebuilt from ${about.directory}.`);
  } catch (trouble) {
    if (moment.until !== until) return;
    tell(byId("when"), trouble.message);
    delete document.body.dataset.shown;
    // Each part says for itself what it can't tell.
    await renewRest();
  }
}

/** What was asked for of another moment is asked for again. */
async function renewRest() {
  const { until } = moment;
  await Promise.all([schemas.list(0), renewOne(), claims.again()]);
  if (moment.until === until) graph.again();
}

async function renewOne() {
  const id = schemas.shownOne();
  if (id !== null) await schemas.showOne(id, true);
}

/** Back to the learner as it is. */
async function present() {
  wanted = null;
  moment.until = null;
  document.body.classList.remove("past");
  delete document.body.dataset.shown;
  byId("present").setAttribute("aria-pressed", "true");
  tell(byId("when"), "");
  tell(byId("rate"), "");
  if (now !== null) showMoment(now, false);
  trace.show();
  await renewRest();
}

/** Orders something, and says what came of it; whether it was obeyed. What it changed is seen in the next look. */
async function order(question, done) {
  try {
    await askNow(question);
    tell(byId("ordered"), done);
    return true;
  } catch (trouble) {
    tell(byId("ordered"), trouble.message);
    return false;
  }
}

const ORDERS = { hold: "It waits.", resume: "It goes on.", step: "It takes one action, and waits." };
for (const [ask, done] of Object.entries(ORDERS)) byId(ask).addEventListener("click", () => order({ ask }, done));
byId("say").addEventListener("submit", async (event) => {
  event.preventDefault();
  const words = byId("words").value.trim().split(/\s+/).filter((word) => word !== "");
  if (words.length === 0) return;
  if (await order({ ask: "say", words }, `It hears “${words.join(" ")}” next.`)) byId("words").value = "";
});
byId("slider").addEventListener("input", () => lookBack(Number(byId("slider").value)));
byId("until").addEventListener("change", () => {
  const input = byId("until");
  if (input.value !== "" && input.checkValidity()) lookBack(Number(input.value));
});
byId("present").addEventListener("click", present);

claims.begin();
schemas.begin(graph.around);
graph.begin((id) => schemas.showOne(id));
trace.show();
follow();
watchPictures();
