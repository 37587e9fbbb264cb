// A small line chart with a mark that moves: SVG, readable in both themes.
import { h, svg } from "./dom";
import { number_text } from "./numbers";

export interface Line {
  name: string;
  x: number[];
  /// null: not known there.
  y: (number | null)[];
  /// "series-1" .. "series-4" of the style sheet.
  style: string;
}

export interface ChartOptions {
  label: string;
  x_label: string;
  height?: number;
  low?: number;
  high?: number;
  /// Colors over x, shown as a strip above.
  strip?: { x: number[]; css: string[] };
  on_x?: (x: number) => void;
}

const kWidth = 300, kLeft = 34, kRight = 8, kBottom = 26, kStrip = 14;

function nice_ticks(low: number, high: number, num: number): number[] {
  const raw = (high - low) / num || 1;
  const unit = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((f) => f * unit).find((s) => s >= raw * 0.999) ?? raw;
  const ticks: number[] = [];
  for (let t = Math.ceil(low / step) * step; t <= high + 1e-9 * step; t += step) ticks.push(Math.abs(t) < 1e-12 * step ? 0 : t);
  return ticks;
}

export interface Chart {
  element: HTMLElement;
  mark(x: number): void;
}

export function chart(lines: Line[], options: ChartOptions): Chart {
  const height = options.height ?? 150;
  const top = 8 + (options.strip ? kStrip + 4 : 0);
  const all_x = lines.flatMap((l) => l.x), all_y = lines.flatMap((l) => l.y).filter((v): v is number => v !== null && Number.isFinite(v));
  const [x0, x1] = [Math.min(...all_x), Math.max(...all_x)];
  let [y0, y1] = [options.low ?? Math.min(...all_y), options.high ?? Math.max(...all_y)];
  if (!(y0 <= y1)) [y0, y1] = [0, 1];
  if (y0 === y1) [y0, y1] = y0 === 0 ? [0, 1] : [y0 - Math.abs(y0) / 2, y1 + Math.abs(y1) / 2];
  const px = (x: number): number => kLeft + ((x - x0) / (x1 - x0 || 1)) * (kWidth - kLeft - kRight);
  const py = (y: number): number => height - kBottom - ((y - y0) / (y1 - y0)) * (height - kBottom - top);
  const root = svg("svg", { viewBox: `0 0 ${kWidth} ${height}`, class: "chart", role: "img", "aria-label": options.label });
  for (const t of nice_ticks(y0, y1, 4)) {
    root.append(svg("line", { x1: kLeft, x2: kWidth - kRight, y1: py(t), y2: py(t), class: "grid" }), svg("text", { x: kLeft - 5, y: py(t) + 3.5, "text-anchor": "end" }, number_text(t)));
  }
  for (const t of nice_ticks(x0, x1, 4)) root.append(svg("text", { x: px(t), y: height - kBottom + 13, "text-anchor": "middle" }, number_text(t)));
  root.append(svg("text", { x: kWidth - kRight, y: height - 2, "text-anchor": "end" }, options.x_label));
  if (options.strip) {
    const { x, css } = options.strip;
    x.forEach((at, i) => {
      const from = i === 0 ? at : (x[i - 1]! + at) / 2, to = i + 1 === x.length ? at : (at + x[i + 1]!) / 2;
      root.append(svg("rect", { x: px(from), y: 4, width: Math.max(1, px(to) - px(from) + 0.5), height: kStrip, fill: css[i]! }));
    });
  }
  for (const line of lines) root.append(svg("polyline", { points: line.x.flatMap((x, i) => { const y = line.y[i]; return y === null || y === undefined || !Number.isFinite(y) ? [] : [`${px(x).toFixed(1)},${py(y).toFixed(1)}`]; }).join(" "), class: `line ${line.style}` }));
  const mark = svg("line", { x1: kLeft, x2: kLeft, y1: 4, y2: height - kBottom, class: "mark" });
  root.append(mark);
  if (options.on_x) {
    const go = (event: PointerEvent): void => {
      const box = root.getBoundingClientRect();
      const x = x0 + ((((event.clientX - box.left) / box.width) * kWidth - kLeft) / (kWidth - kLeft - kRight)) * (x1 - x0);
      options.on_x?.(Math.min(Math.max(x, x0), x1));
    };
    root.addEventListener("pointerdown", (e) => { root.setPointerCapture(e.pointerId); go(e); });
    root.addEventListener("pointermove", (e) => { if (root.hasPointerCapture(e.pointerId)) go(e); });
    root.classList.add("active");
  }
  const keys = h("div", { class: "keys-of-lines" }, lines.map((l) => h("span", { class: `key ${l.style}` }, l.name)));
  return {
    element: h("div", { class: "chart-box" }, root as unknown as Node, keys),
    mark: (x) => {
      mark.setAttribute("x1", String(px(x)));
      mark.setAttribute("x2", String(px(x)));
    },
  };
}
