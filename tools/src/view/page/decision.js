// The last decision: what could have been done, and the sums that decided.

import { binding, byId, el, isBeingRead, level, observation, share, tell } from "./dom.js";

const panel = byId("why");
const open = new Set();
let shownStep = null;

/** Shows the decision of a moment, or why there is none; while somebody reads the last one it stays. */
export function showDecision({ explanation: decision, sentence, undecided }, force, onSchema) {
  if (decision === null) {
    shownStep = null;
    tell(byId("sentence"), undecided ?? "Nothing has been decided yet.");
    tell(byId("why-note"), "");
    byId("candidates").replaceChildren();
    return;
  }
  if (decision.step === shownStep && !force) return;
  if (!force && shownStep !== null && isBeingRead(panel)) {
    tell(byId("why-note"), `Step ${shownStep}, kept while you are here; the learner is at step ${decision.step}.`);
    return;
  }
  shownStep = decision.step;
  tell(byId("sentence"), sentence);
  const listed = decision.candidates.length;
  tell(byId("why-note"), `Step ${decision.step}: ${listed} of ${decision.candidates_total} candidates. `
    + "Each part of a bar is a term of equation (1); they add up to E × distance.");
  const most = Math.max(...decision.candidates.map((one) => sum(one)), 1e-9);
  byId("candidates").replaceChildren(...decision.candidates.map((one, at) =>
    candidate(one, at, at === decision.chosen, most, onSchema)));
}

const sum = (candidate) => candidate.terms.reduce((total, term) => total + term.value, 0);

function candidate(one, at, chosen, most, onSchema) {
  const values = binding(one.binding);
  const text = values === "" ? one.text : `${one.text}, with ${values}`;
  const details = el("details", { open: open.has(at) },
    el("summary", {},
      el("span", { class: "e" }, `E ${level(one.excitation)}`),
      chosen ? el("b", {}, "chosen ") : null,
      el("span", { class: "code" }, one.schema === null ? `primitive ${text}` : `${one.schema}: ${text}`),
      bar(one.terms, most)),
    terms(one, most),
    one.schema === null ? null
      : el("button", { type: "button", onclick: () => onSchema(one.schema) }, `Show schema ${one.schema}`));
  details.addEventListener("toggle", () => (details.open ? open.add(at) : open.delete(at)));
  return el("li", { class: chosen ? "chosen" : "" }, details);
}

function bar(list, most) {
  const told = list.map((term) => `${term.role} ${level(term.value)}`).join(", ");
  const whole = el("span", { class: "bar", role: "img", "aria-label": `Terms: ${told}` });
  for (const term of list) whole.append(part(term, most));
  return whole;
}

function part(term, most) {
  const node = el("i", { class: term.role, title: `${term.role}: ${level(term.value)}` });
  node.style.width = `${Math.max(0, Math.min(100, (term.value / most) * 100)).toFixed(2)}%`;
  return node;
}

const written = (one) => (one === null ? "–" : observation(one));

// The schemas that achieve a target together, where no single one does.
function together(one) {
  const parts = (one.together || []).map((part) => `schema ${part.id} (${part.action})`);
  return parts.length === 0 ? "" : `. No single schema achieves its target; ${parts.join(", then ")} do together.`;
}

function terms(one, most) {
  const heads = ["term", "remembered", "seen", "same", "prob", "weight", "1+N", "value", ""];
  const rows = one.terms.map((term) => el("tr", {},
    el("td", {}, term.role),
    el("td", { class: "code" }, written(term.observation)),
    el("td", { class: "code" }, written(term.seen)),
    el("td", { class: "n" }, String(term.shared)),
    el("td", { class: "n" }, level(term.probability)),
    el("td", { class: "n" }, level(term.weight)),
    el("td", { class: "n" }, String(term.attention + 1)),
    el("td", { class: "n" }, level(term.value)),
    el("td", {}, el("span", { class: "bar", "aria-hidden": "true" }, part(term, most)))));
  return el("div", { class: "scroll terms" },
    el("table", {},
      el("thead", {}, el("tr", {}, heads.map((head, at) => el("th", { class: at >= 3 && at <= 7 ? "n" : "" }, head)))),
      el("tbody", {}, rows)),
    el("p", { class: "facts" },
      `sum ${level(sum(one))} / distance ${one.distance} = E ${level(one.excitation)}${together(one)}`));
}
