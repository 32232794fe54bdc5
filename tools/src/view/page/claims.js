// The claims about actions, as text that the program makes.

import { ask, turns } from "./ask.js";
import { byId, tell, whole } from "./dom.js";

const PAGE = 10;
const form = byId("claims-of");
const turn = turns();
let offset = 0;
let listed = false;

/** Begins. */
export function begin() {
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    list(0);
  });
  byId("claims-earlier").addEventListener("click", () => list(Math.max(0, offset - PAGE)));
  byId("claims-later").addEventListener("click", () => list(offset + PAGE));
}

/** Lists them again, if they were listed. */
export const again = () => (listed ? list(0) : undefined);

async function list(from) {
  const action = String(new FormData(form).get("action") ?? "").trim() || null;
  const isWanted = turn();
  listed = true;
  let answer = { matching: 0, text: "" };
  let note = "";
  try {
    answer = await ask({ ask: "claims", action, limit: PAGE, offset: from });
    if (answer.matching > 0) note = `${whole(answer.matching)} groups of types that change together.`;
  } catch (trouble) {
    note = trouble.message;
  }
  if (!isWanted()) return;
  offset = from;
  tell(byId("claims-note"), note);
  tell(byId("claims-text"), answer.text);
  byId("claims-text").hidden = answer.text === "";
  byId("claims-earlier").disabled = offset === 0;
  byId("claims-later").disabled = offset + PAGE >= answer.matching;
}
