// Labeled controls: what panels are made of.
import { h, type Child } from "./dom";
import { icon } from "./icons";
import { unique_id } from "./numbers";

export { number_text } from "./numbers";
export { number_field, slider, type NumberField, type Slider, type SliderOptions } from "./slider";

export interface Choice<T extends string> {
  element: HTMLElement;
  set(value: T): void;
  get(): T;
}

/// A list to choose from. `options`: [value, text].
export function select<T extends string>(label: string, options: [T, string][], value: T, on_change: (value: T) => void): Choice<T> & { set_options(options: [T, string][]): void } {
  const id = unique_id();
  const items = (list: [T, string][]): HTMLOptionElement[] => list.map(([v, text]) => h("option", { value: v }, text));
  const input = h("select", { id, onchange: () => on_change(input.value as T) }, items(options));
  input.value = value;
  return {
    element: h("div", { class: "control row" }, h("label", { for: id }, label), input),
    set: (v) => { input.value = v; },
    get: () => input.value as T,
    set_options: (list) => {
      const v = input.value;
      input.replaceChildren(...items(list));
      input.value = v;
    },
  };
}

/// A few choices side by side: [value, text, hint].
export function segmented<T extends string>(label: string, options: [T, string, string?][], value: T, on_change: (value: T) => void): Choice<T> {
  let current = value;
  const buttons = options.map(([v, text, hint]) => h("button", { type: "button", role: "radio", title: hint, "data-value": v, onclick: () => choose(v, true) }, text));
  const choose = (v: T, is_told: boolean): void => {
    if (v === current && is_told) return;
    current = v;
    for (const b of buttons) {
      b.setAttribute("aria-checked", String(b.dataset["value"] === v));
      b.tabIndex = b.dataset["value"] === v ? 0 : -1;
    }
    if (is_told) on_change(v);
  };
  const on_key = (event: KeyboardEvent): void => {
    const by = event.key === "ArrowRight" || event.key === "ArrowDown" ? 1 : event.key === "ArrowLeft" || event.key === "ArrowUp" ? -1 : 0;
    if (by === 0) return;
    event.preventDefault();
    event.stopPropagation();
    const next = (options.findIndex(([v]) => v === current) + by + options.length) % options.length;
    choose(options[next]![0], true);
    buttons[next]?.focus();
  };
  const element = h("div", { class: "segmented", role: "radiogroup", "aria-label": label, onkeydown: on_key }, buttons);
  choose(value, false);
  return { element, get: () => current, set: (v) => choose(v, false) };
}

export interface Toggle {
  element: HTMLElement;
  set(value: boolean): void;
  get(): boolean;
}

export function toggle(label: string, value: boolean, on_change: (value: boolean) => void, hint?: string): Toggle {
  const id = unique_id();
  const input = h("input", { type: "checkbox", id, role: "switch", checked: value, onchange: () => on_change(input.checked) });
  return { element: h("div", { class: "control row switch", title: hint }, h("label", { for: id }, label), input), set: (v) => { input.checked = v; }, get: () => input.checked };
}

export function button(text: string, on_click: () => void, options: { icon?: string; kind?: "primary" | "quiet"; hint?: string; key?: string } = {}): HTMLButtonElement {
  const hint = options.hint && options.key ? `${options.hint} (${options.key})` : options.hint;
  return h("button", { type: "button", class: options.kind ?? "", title: hint, onclick: on_click }, options.icon ? icon(options.icon) : null, text ? h("span", {}, text) : null);
}

/// Only an icon; `label` is the hint and what a screen reader says.
export function icon_button(name: string, label: string, on_click: () => void, key?: string): HTMLButtonElement {
  return h("button", { type: "button", class: "quiet icon-only", "aria-label": label, title: key ? `${label} (${key})` : label, onclick: on_click }, icon(name));
}

/// A part of a panel that folds.
export function section(title: string, is_open: boolean, ...children: (Child | Child[])[]): HTMLDetailsElement {
  const element = h("details", { class: "section" }, h("summary", {}, title), h("div", { class: "body" }, ...children));
  element.open = is_open;
  return element;
}
