// Elements without ceremony.

export type Child = Node | string | number | null | undefined | false;
type Props = Record<string, unknown>;

/// h("button", {class: "x", onclick: f, "aria-label": "y"}, children...). Functions and "value"-like names are set as properties.
export function h<K extends keyof HTMLElementTagNameMap>(tag: K, props: Props = {}, ...children: (Child | Child[])[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(props)) {
    if (value === undefined || value === null || value === false) continue;
    if (name === "class") element.className = String(value);
    else if (name === "style") element.style.cssText = String(value);  // The attribute is forbidden by the page's security policy.
    else if (typeof value === "function" || name === "value" || name === "checked" || name === "disabled") (element as unknown as Props)[name] = value;
    else element.setAttribute(name, value === true ? "" : String(value));
  }
  append(element, children);
  return element;
}

export function append(parent: Element, children: (Child | Child[])[]): void {
  for (const child of children.flat()) {
    if (child === null || child === undefined || child === false) continue;
    parent.append(child instanceof Node ? child : String(child));
  }
}

export function replace(parent: Element, ...children: (Child | Child[])[]): void {
  parent.replaceChildren();
  append(parent, children);
}

const kSvg = "http://www.w3.org/2000/svg";

export function svg(tag: string, props: Record<string, string | number> = {}, ...children: (SVGElement | string)[]): SVGElement {
  const element = document.createElementNS(kSvg, tag) as SVGElement;
  for (const [name, value] of Object.entries(props)) element.setAttribute(name, String(value));
  element.append(...children);
  return element;
}

/// At most one call in `ms`, the newest; at once where nothing came before.
export function throttle<A extends unknown[]>(ms: number, f: (...args: A) => void): (...args: A) => void {
  let last = -Infinity;
  let timer: number | undefined;
  let newest: A;
  return (...args: A) => {
    newest = args;
    if (timer !== undefined) return;
    const wait = last + ms - performance.now();
    const go = (): void => {
      timer = undefined;
      last = performance.now();
      f(...newest);
    };
    if (wait <= 0) go();
    else timer = window.setTimeout(go, wait);
  };
}
