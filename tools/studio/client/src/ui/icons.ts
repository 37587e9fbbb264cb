// Icons of 24 x 24, drawn with strokes in the color of the text.
import { svg } from "./dom";

const kPaths: Record<string, string> = {
  play: "M8 5.5v13l10.5-6.5z",
  pause: "M8 5v14M16 5v14",
  step: "M6 5.5v13l9-6.5zM18.5 5v14",
  back: "M18 5.5v13L9 12zM5.5 5v14",
  reset: "M4.5 12a7.5 7.5 0 1 0 2.4-5.5M7 3v4h4",
  fit: "M4 9V4h5M20 9V4h-5M4 15v5h5M20 15v5h-5",
  full: "M14 10l6-6M15 4h5v5M10 14l-6 6M9 20H4v-5",
  sun: "M12 8a4 4 0 1 0 0 8 4 4 0 0 0 0-8M12 2.5v2M12 19.5v2M2.5 12h2M19.5 12h2M5.3 5.3l1.4 1.4M17.3 17.3l1.4 1.4M5.3 18.7l1.4-1.4M17.3 6.7l1.4-1.4",
  moon: "M19.5 14.5A8 8 0 0 1 9.5 4.5a8 8 0 1 0 10 10z",
  help: "M9.2 9.2a2.9 2.9 0 1 1 4.3 2.5c-1 .6-1.5 1.2-1.5 2.3M12 17.5v.2M12 2.8a9.2 9.2 0 1 0 0 18.4 9.2 9.2 0 0 0 0-18.4",
  undo: "M4.5 9h9a5 5 0 0 1 0 10H9M8 5L4 9l4 4",
  redo: "M19.5 9h-9a5 5 0 0 0 0 10H16M16 5l4 4-4 4",
  save: "M5 4h11l3 3v13H5zM8 4v5h7V4M8 20v-6h8v6",
  download: "M12 4v11M7.5 11l4.5 4.5 4.5-4.5M5 20h14",
  brush: "M14 6l4 4-8 8c-2 2-5 2-6 1.5 1.5-1 1-3 2-5.5zM14 6l3-3 4 4-3 3",
  move: "M12 3v18M3 12h18M9 6l3-3 3 3M9 18l3 3 3-3M6 9l-3 3 3 3M18 9l3 3-3 3",
  rotate: "M19.5 12a7.5 7.5 0 1 1-2.4-5.5M17 3v4h-4",
  scale: "M4 14v6h6M20 10V4h-6M4 20l7-7M20 4l-7 7",
  plus: "M12 5v14M5 12h14",
  jobs: "M4 6h10M4 12h16M4 18h7",
  copy: "M9 9h11v11H9zM5 15H4V4h11v1",
  close: "M6 6l12 12M18 6L6 18",
  history: "M4 12a8 8 0 1 0 2.4-5.7L4 8.5M4 4v4.5h4.5M12 8v4.5l3 1.8",
  transfer: "M4 8h13l-3.5-3.5M20 16H7l3.5 3.5",
  simulation: "M12 3.5c3 4 5.5 6.8 5.5 10a5.5 5.5 0 0 1-11 0c0-3.2 2.5-6 5.5-10zM9.5 14.5a2.6 2.6 0 0 0 2.5 2.4",
  scene: "M12 3l8 4.5v9L12 21l-8-4.5v-9zM4 7.5l8 4.5 8-4.5M12 12v9",
  ingest: "M4 7.5h4l1.5-2.5h5L16 7.5h4V19H4zM12 9.5a3.4 3.4 0 1 0 0 6.8 3.4 3.4 0 0 0 0-6.8",
  registration: "M4 15V5h10v10zM10 9h10v10H10z",
  unlit: "M12 3v3M5.6 5.6l2.1 2.1M18.4 5.6l-2.1 2.1M4 20h16M6.5 20a5.5 5.5 0 0 1 11 0",
  calibration: "M4 4h16v16H4zM4 12h16M12 4v16",
  mesh: "M12 3l9 16H3zM12 3v9M3 19l9-7 9 7",
  report: "M6 3h9l4 4v14H6zM9 12h7M9 16h7M9 8h3",
};

export function icon(name: string, size = 20): SVGElement {
  const path = svg("path", { d: kPaths[name] ?? kPaths["report"]!, fill: name === "play" ? "currentColor" : "none", stroke: "currentColor", "stroke-width": 1.7, "stroke-linejoin": "round", "stroke-linecap": "round" });
  return svg("svg", { viewBox: "0 0 24 24", width: size, height: size, "aria-hidden": "true", class: "icon" }, path);
}
