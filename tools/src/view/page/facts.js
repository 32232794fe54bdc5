// How the learner and what is attached to it are.

import { byId, bytes, duration, el, whole } from "./dom.js";

/** Shows the figures of a moment; with `past`, only those that memory has. */
export function showFacts(live, past) {
  const rows = [
    ["profile", live.profile],
    ["curriculum", live.curriculum],
    ["stage", `${live.stage}: ${live.stage_state}`],
    ["saturation", saturation(live.saturation)],
    ["habituation", live.habituation === null ? null : habituation(live.habituation)],
    ["trial", trial(live.trial)],
    ["schemas", `${whole(live.schemas_total)}, ${whole(live.schemas_generalised)} generalised`],
    ["step", whole(live.step)],
  ];
  if (!past) {
    rows.push(
      ["durable step", live.durable_step === null ? "memory is in RAM only" : whole(live.durable_step)],
      ["steps a second", live.steps_per_s.toFixed(1)],
      ["step latency, median and 99 %", `${duration(live.step_latency_us_p50)}, ${duration(live.step_latency_us_p99)}`],
      ["frame to reply, median and 99 %", `${duration(live.commit_latency_us_p50)}, ${duration(live.commit_latency_us_p99)}`],
      ["memory of the daemon", memory(live)],
      ["up", `${whole(Math.round(live.uptime_s))} s`],
      ...live.bodies.flatMap((body) => [
        [`body ${body.id}`,
          `${body.name} (${body.kind}): ${body.state}, ${whole(body.frames)} frames, ${whole(body.frames_refused)} refused`],
        [`episodes of body ${body.id}`, episodes(body)],
        ...body.warnings.map((one) => [`warning for body ${body.id}`, warning(one)]),
      ]),
    );
  }
  byId("figures").replaceChildren(...rows.filter(([, value]) => value !== null)
    .map(([name, value]) => el("div", {}, el("dt", {}, name), el("dd", {}, value))));
}

function episodes(body) {
  if (body.episodes_ended + body.episodes_cut === 0) return null;
  return `${whole(body.episodes_ended)} ended, ${whole(body.episodes_cut)} cut short`;
}

/** What keeps a body's declaration from being learnt; `pschema status` says more. */
function warning(one) {
  switch (one.fault) {
    case "values-never-repeat":
      return `${one.sense} hardly ever has the same values: ${whole(one.repeated)} of ${whole(one.observations)} had come before`;
    case "actions-never-repeat":
      return `of ${whole(one.primitives)} primitives hardly any is tried twice: ${whole(one.repeated)} of ${whole(one.actions)} actions`;
    case "own-decides":
      return `what actions do goes by ${one.senses.join(" and ")}, which may be no pre-condition under this profile`;
    default:
      return one.fault;
  }
}

function memory(live) {
  const limit = live.memory_max_bytes === null ? "" : ` of at most ${bytes(live.memory_max_bytes)}`;
  return bytes(live.memory_bytes) + limit + (live.memory_full ? "; it is full, and nothing new is learnt" : "");
}

function saturation(one) {
  if (one === null) return null;
  return `${whole(one.quiet_actions)} of ${whole(one.quiet_actions_wanted)} quiet actions in a row`;
}

function habituation(one) {
  return one.habituation_left === null ? "not before saturation" : `${whole(one.habituation_left)} schemas left`;
}

function trial(one) {
  if (one === null) return null;
  const of = one.actions_max === null ? "" : ` of ${whole(one.actions_max)}`;
  return `${whole(one.trial)} of ${whole(one.trials_wanted)}, ${whole(one.actions)}${of} actions`;
}
