// Making and changing what is shown. Text of others is only ever set as text.

export const byId = (id) => document.getElementById(id);

/** An element with attributes (`on…` are listeners) and children; strings become text. */
export function el(tag, attributes = {}, ...children) {
  return filled(document.createElement(tag), attributes, children);
}

/** The same of a drawing. */
export function draw(tag, attributes = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", tag), attributes, children);
}

function filled(node, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) node.addEventListener(name.slice(2), value);
    else if (value === true) node.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) node.setAttribute(name, String(value));
  }
  node.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return node;
}

/** Sets text where it is another. */
export function tell(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** Whether somebody is reading here: what changes under the eyes can't be read, and focus must not be lost. */
export function isBeingRead(node) {
  return node.matches(":hover") || node.contains(document.activeElement);
}

export const whole = (number) => Number(number).toLocaleString("en");
export const share = (number) => Number(number).toFixed(2);

/** A figure of excitation: with three decimals, or if it is small, with three digits that say something. */
export function level(number) {
  const size = Math.abs(number);
  if (size === 0 || size >= 0.1) return Number(number).toFixed(3);
  return size < 1e-5 ? Number(number).toExponential(2) : Number(number).toPrecision(3);
}

export function duration(us) {
  if (us < 1000) return `${us.toFixed(0)} µs`;
  if (us < 1e6) return `${(us / 1e3).toFixed(1)} ms`;
  return `${(us / 1e6).toFixed(1)} s`;
}

export function bytes(count) {
  const units = ["B", "KiB", "MiB", "GiB", "TiB"];
  let at = 0;
  for (; count >= 1024 && at + 1 < units.length; at += 1) count /= 1024;
  return `${count.toFixed(at === 0 ? 0 : 1)} ${units[at]}`;
}

/** A value as it is written; a variable has its name after a dollar sign. */
export const value = (one) => (one !== null && typeof one === "object" ? `$${one.var}` : String(one));

/** An observation as it is written. */
export function observation(one) {
  const properties = Object.entries(one.properties).map(([name, known]) => `${name}=${value(known)}`);
  return `${one.type}{${properties.join(", ")}}`;
}

/** The values of variables as they are written; empty for none. */
export const binding = (values) => Object.entries(values).map(([name, known]) => `$${name}=${value(known)}`).join(", ");

/** The words before an observation that is no longer there. */
const NO_LONGER = "no longer ";

/** The observation, if its opposite is an outcome as well: the two exclude each other. */
function opposites(outcome, post) {
  const isGone = outcome.startsWith(NO_LONGER);
  const observation = isGone ? outcome.slice(NO_LONGER.length) : outcome;
  return post.includes(isGone ? observation : NO_LONGER + observation) ? observation : null;
}

/** Outcomes as they are written. Those of one type that did not always hold, and whose shares leave room for it, may exclude each other. */
function outcomes(post, shares) {
  const rounded = (share) => (share > 0 && share < 0.005 ? "<1" : share >= 0.995 ? ">99" : Math.round(share * 100));
  const sides = [];
  post.forEach((outcome, at) => {
    const share = shares[at] ?? 1;
    const observation = opposites(outcome, post);
    const kind = observation ?? outcome.split("{")[0];
    const written = share < 1 ? `${outcome} ${rounded(share)} %` : outcome;
    const side = sides.find((one) => one.kind === kind && (observation !== null || one.share + share <= 1 + 1e-9));
    if (side === undefined) {
      sides.push({ kind, share, written: [written] });
    } else {
      side.share += share;
      side.written.push(written);
    }
  });
  return sides.map((side) => (side.written.length > 1 ? `(${side.written.join(" or ")})` : side.written[0]));
}

/** A schema as it is written. */
export function notation(schema) {
  const side = (list) => (list.length === 0 ? "∅" : list.join(" & "));
  return `${side(schema.pre)} / ${schema.action} / ${side(outcomes(schema.post, schema.post_shares))}`;
}
