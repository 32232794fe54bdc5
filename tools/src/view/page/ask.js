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

/**
 * Makes a function to be called before each of several questions of one kind; what that gives tells, once the answer is
 * there, whether it is still wanted: nothing was asked since, and the same moment is looked at.
 */
export function turns() {
  let last = 0;
  return () => {
    const turn = (last += 1);
    const { until } = moment;
    return () => turn === last && until === moment.until;
  };
}

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
