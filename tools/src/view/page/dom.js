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

/** An excitation, with three digits after the point as everywhere. */
export const level = (number) => Number(number).toFixed(3);

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

/** A schema as it is written. */
export function notation(schema) {
  const side = (list) => (list.length === 0 ? "∅" : list.join(" & "));
  return `${side(schema.pre)} / ${schema.action} / ${side(schema.post)}`;
}
