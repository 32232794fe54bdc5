// The network of schemas, as `pschema graph` draws it; here its nodes can be opened.

import { ask, turns } from "./ask.js";
import { byId, tell, whole } from "./dom.js";

const form = byId("draw");
const root = byId("drawing").attachShadow({ mode: "open" });
let onSchema = () => {};
let view = null;
const turn = turns();
/** Whether a drawing is wanted at all. */
let wanted = false;

/** Begins; `open` is called with a schema that was picked. */
export function begin(open) {
  onSchema = open;
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    show();
  });
  byId("zoom-in").addEventListener("click", () => zoom(0.7));
  byId("zoom-out").addEventListener("click", () => zoom(1 / 0.7));
  byId("zoom-all").addEventListener("click", () => view?.whole());
}

/** Draws what is around a schema. */
export function around(id) {
  form.elements.around.value = String(id);
  show();
  byId("graph").scrollIntoView({ block: "start" });
}

/** Draws again what was asked for, if anything was: another moment is looked at. */
export function again() {
  if (wanted) show();
}

async function show() {
  const given = form.elements.around.value.trim();
  const isWanted = turn();
  wanted = true;
  tell(byId("graph-note"), "Drawing…");
  try {
    const graph = await ask({ ask: "graph", around: given === "" ? null : Number(given), depth: Number(form.elements.depth.value) || 1 });
    if (!isWanted()) return;
    place(graph);
    tell(byId("graph-note"), `Step ${whole(graph.step)}: ${whole(graph.nodes_total)} schemas, ${whole(graph.shown)} told one by one, `
      + `${whole(graph.edges_total)} ties.${graph.truncated ? " Not all is told: draw around one of them." : ""} Ctrl or Shift with the wheel, or + and −, zoom; drag moves; a node opens.`);
  } catch (trouble) {
    if (isWanted()) tell(byId("graph-note"), trouble.message);
  }
}

/** Puts the drawing into a tree of its own, so that its style is its own too. */
function place(graph) {
  const parsed = new DOMParser().parseFromString(graph.svg, "image/svg+xml");
  if (parsed.querySelector("parsererror") !== null) throw new Error("the drawing can't be read");
  const sheet = new CSSStyleSheet();
  sheet.replaceSync(`:host{display:block}svg{display:block;width:100%;height:100%;touch-action:none;cursor:grab}`
    + `.node[role=button]{cursor:pointer}.node:focus-visible .shape{stroke-width:4}${graph.style}`);
  root.adoptedStyleSheets = [sheet];
  const svg = document.importNode(parsed.documentElement, true);
  // Its nodes can be used, each by its own name.
  svg.setAttribute("role", "group");
  root.replaceChildren(svg);
  const { width, height } = svg.viewBox.baseVal;
  byId("drawing").style.height = `min(70vh, ${Math.ceil((byId("drawing").clientWidth * height) / width)}px)`;
  for (const node of svg.querySelectorAll("g.node")) prepare(svg, node, graph.schemas[Number(node.id.slice(1))]);
  view = movable(svg);
}

function prepare(svg, node, schema) {
  const number = node.id.slice(1);
  const lines = [...svg.querySelectorAll(`.f${CSS.escape(number)}, .t${CSS.escape(number)}`)];
  const light = (on) => {
    svg.classList.toggle("dim", on && lines.length > 0);
    for (const line of lines) line.classList.toggle("lit", on);
  };
  for (const [name, on] of [["pointerenter", true], ["pointerleave", false], ["focus", true], ["blur", false]]) {
    node.addEventListener(name, () => light(on));
  }
  if (schema === null || schema === undefined) return;
  node.setAttribute("role", "button");
  node.setAttribute("tabindex", "0");
  node.setAttribute("aria-label", `Show schema ${schema}`);
  node.addEventListener("click", () => view.moved || onSchema(schema));
  node.addEventListener("keydown", (event) => {
    if (event.key === "Enter" || event.key === " ") {
      event.preventDefault();
      onSchema(schema);
    }
  });
}

function movable(svg) {
  const box = svg.viewBox.baseVal;
  const first = { x: box.x, y: box.y, width: box.width, height: box.height };
  const state = { moved: false, whole: () => Object.assign(box, first) };
  const at = (event) => new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
  // What is small can be read only when it is near.
  const near = () => svg.classList.toggle("near", svg.getBoundingClientRect().width / box.width > 2.6);
  state.zoom = (by, point = { x: box.x + box.width / 2, y: box.y + box.height / 2 }) => {
    const factor = Math.min(Math.max(by, 80 / box.width), (first.width * 1.2) / box.width);
    box.x = point.x - (point.x - box.x) * factor;
    box.y = point.y - (point.y - box.y) * factor;
    box.width *= factor;
    box.height *= factor;
    near();
  };
  let held = null;
  svg.addEventListener("wheel", (event) => {
    // With a key held it zooms; without, the page scrolls on.
    if (!event.ctrlKey && !event.shiftKey && !event.metaKey) return;
    event.preventDefault();
    state.zoom(Math.exp((event.deltaY || event.deltaX) * 0.0015), at(event));
  }, { passive: false });
  svg.addEventListener("pointerdown", (event) => {
    held = at(event);
    state.moved = false;
  });
  svg.addEventListener("pointermove", (event) => {
    if (held === null || event.buttons === 0) return;
    const now = at(event);
    if (Math.hypot(now.x - held.x, now.y - held.y) > 4) state.moved = true;
    box.x += held.x - now.x;
    box.y += held.y - now.y;
  });
  svg.addEventListener("pointerup", () => (held = null));
  near();
  return state;
}

const zoom = (by) => view?.zoom(by);
