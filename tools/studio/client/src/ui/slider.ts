// A slider with a number field beside it: both show one value, and either sets it.
import { h } from "./dom";
import { number_text, parse_number, unique_id } from "./numbers";

export interface Slider {
  element: HTMLElement;
  set(value: number): void;
  get(): number;
}

export interface SliderOptions {
  label: string;
  low: number;
  high: number;
  step?: number;
  value: number;
  /// Equal ways are equal factors; `low` must be above 0.
  logarithmic?: boolean;
  unit?: string;
  /// What the field shows of the value 1: 100 for percent.
  factor?: number;
  hint?: string;
  /// A number above `high` may be typed; the slider then ends there.
  open?: boolean;
  on_input?: (value: number) => void;
}

const kLogSteps = 1000;

export function slider(options: SliderOptions): Slider {
  const id = unique_id();
  const { low, factor = 1 } = options;
  let { high } = options;
  const is_log = options.logarithmic === true;
  const to_input = (value: number): number => (is_log ? (kLogSteps * Math.log(Math.max(value, low) / low)) / Math.log(high / low) : value);
  const from_input = (value: number): number => (is_log ? low * (high / low) ** (value / kLogSteps) : value);
  const text = (value: number): string => number_text(value * factor) + (options.unit ? ` ${options.unit}` : "");
  const input = h("input", { type: "range", id, min: is_log ? 0 : low, max: is_log ? kLogSteps : high, step: is_log ? 1 : (options.step ?? (high - low) / 200) });
  const field = h("input", { type: "text", inputmode: "decimal", class: "number-field", "aria-label": `${options.label}${options.unit ? `, ${options.unit}` : ""}`, autocomplete: "off", spellcheck: "false" });
  let current = options.value;
  const put_text = (): void => { field.value = field.defaultValue = number_text(current * factor); };
  const show = (): void => {
    if (document.activeElement !== field || field.value === field.defaultValue) put_text();
    input.setAttribute("aria-valuetext", text(current));
    input.style.setProperty("--share", `${(100 * (Number(input.value) - Number(input.min))) / (Number(input.max) - Number(input.min) || 1)}%`);
  };
  const put = (value: number): void => {
    current = value;
    if (value > high && options.open) {
      high = value;
      if (!is_log) input.max = String(high);
    }
    input.value = String(to_input(value));
    show();
  };
  const set = (value: number): void => {
    if (!input.matches(":active")) put(value);  // Never pull a handle out of the user's hand.
  };
  input.oninput = () => {
    current = from_input(Number(input.value));
    show();
    options.on_input?.(current);
  };
  // What is typed counts with Enter, or when the field is left; what is no number changes nothing.
  const take = (): void => {
    const typed = parse_number(field.value);
    if (typed !== undefined) {
      const value = Math.min(Math.max(typed / factor, low), options.open ? Infinity : high);
      if (field.value !== number_text(current * factor)) {
        put(value);
        options.on_input?.(value);
      }
    }
    put_text();
  };
  field.onchange = take;
  field.onfocus = () => field.select();
  field.onkeydown = (event) => {
    const by = event.key === "ArrowUp" ? 1 : event.key === "ArrowDown" ? -1 : 0;
    if (event.key === "Enter") take();
    else if (event.key === "Escape") put_text();
    else if (by !== 0) {
      const value = is_log ? current * 1.02 ** by : current + by * Number(input.step);
      put(Math.min(Math.max(value, low), high));
      put_text();
      options.on_input?.(current);
    } else return;
    event.preventDefault();
    if (event.key === "Enter") field.select();
  };
  put(options.value);
  const element = h("div", { class: "control", title: options.hint }, h("label", { for: id }, options.label), h("span", { class: "value" }, field, options.unit ? h("span", { class: "unit" }, options.unit) : null), input);
  return { element, get: () => current, set };
}

export interface NumberField {
  element: HTMLElement;
  set(value: number): void;
  set_unit(unit: string): void;
}

/// A number to type, with its unit. What is no number changes nothing.
export function number_field(label: string, value: number, unit: string, on_value: (value: number) => void): NumberField {
  const id = unique_id();
  let current = value;
  const input = h("input", { type: "text", inputmode: "decimal", id, class: "number-field", autocomplete: "off", spellcheck: "false" });
  const unit_box = h("span", { class: "unit" }, unit);
  const show = (): void => { input.value = number_text(current, 4); };
  const take = (): void => {
    const typed = parse_number(input.value);
    const is_other = typed !== undefined && input.value !== number_text(current, 4);
    if (is_other) current = typed;
    show();
    if (is_other) on_value(current);
  };
  input.onchange = take;
  input.onfocus = () => input.select();
  input.onkeydown = (event) => {
    if (event.key === "Enter") take();
    if (event.key === "Escape") show();
  };
  show();
  return {
    element: h("div", { class: "control row" }, h("label", { for: id }, label), h("span", { class: "value" }, input, unit_box)),
    set: (v) => { current = v; show(); },
    set_unit: (text) => { unit_box.textContent = text; },
  };
}
