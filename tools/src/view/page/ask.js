// Asking the learner: the daemon for what is now, the memory on disk for what was.

export class Trouble extends Error {
  constructor(problem, noDaemon) {
    super(problem);
    this.noDaemon = noDaemon;
  }
}

/** What the page looks at: now, or memory as it was after a step. */
export const moment = { until: null };

/** Asks a question of now. */
export const askNow = (question) => asked({ question });

/** Asks a question of the moment that is looked at. */
export const ask = (question) => asked({ question, until: moment.until });

async function asked(what) {
  let reply;
  try {
    reply = await fetch("./ask", {
      method: "POST",
      headers: { "Content-Type": "application/json" },
      body: JSON.stringify(what),
    });
  } catch {
    throw new Trouble("`pschema view` has ended: start it again and open the address it prints.", false);
  }
  let answer = null;
  try {
    answer = await reply.json();
  } catch {
    // What is no JSON is told by its status.
  }
  if (!reply.ok || answer === null) {
    throw new Trouble(answer?.problem ?? `no answer (${reply.status})`, answer?.no_daemon === true);
  }
  return answer;
}
