// The page's parts. Strings become text nodes and nothing else, whatever they hold.

const el = (tag, attributes = {}, ...children) => filled(document.createElement(tag), attributes, children);

function filled(element, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "on") {
      for (const [event, handler] of Object.entries(value)) element.addEventListener(event, handler);
    } else if (value === true) {
      element.setAttribute(name, "");
    } else if (value !== false && value !== null && value !== undefined) {
      element.setAttribute(name, value);
    }
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

// A string of the document: set apart, so that its writing direction stays its own affair.
const said = (text, tag = "span", attributes = {}) => el(tag, { dir: "auto", class: "said", ...attributes }, String(text ?? ""));

const readJson = (id) => JSON.parse(document.getElementById(id).textContent);

// Someone who says when it changed, and those who listen.
function createSignal() {
  const listeners = new Set();
  return {
    on(listener) {
      listeners.add(listener);
      return () => listeners.delete(listener);
    },
    tell() {
      for (const listener of [...listeners]) listener();
    },
  };
}
