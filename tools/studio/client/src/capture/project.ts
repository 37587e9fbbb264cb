// What a person sets in the project of a capture with a photograph in view; as the project says it, too.
import type { MarkedPhoto } from "./landmarks";
import type { Region } from "./photo_pane";

export type Corner = [number, number];

/// What GET /api/project says.
export interface ProjectInfo {
  state: string;
  photos: MarkedPhoto[];
  reference: number | null;  ///< The number of the photograph whose pixels are meant; null: all have the same.
  width: number;
  height: number;
  file: string;
  roi: Region | null;
  mask: string | null;
  is_mask_shown: boolean;
  texel_size_mm: number | null;
  chart: "auto" | { corners?: Corner[] } | null;
}

export type Members = Pick<ProjectInfo, "roi" | "texel_size_mm" | "chart">;
export const kMembers = ["roi", "texel_size_mm", "chart"] as const;

export const members_of = ({ roi, texel_size_mm, chart }: ProjectInfo): Members => ({ roi, texel_size_mm, chart });
export const corners_of = (chart: Members["chart"]): Corner[] => (chart !== null && chart !== "auto" ? chart.corners ?? [] : []);

/// The rectangle between two places, in whole pixels of a photograph; nothing where it is only a click.
export function roi_between(ax: number, ay: number, bx: number, by: number, width: number, height: number): Region | null {
  const edge = (v: number, size: number): number => Math.min(size, Math.max(0, Math.round(v + 0.5)));
  const [x0, x1] = [edge(Math.min(ax, bx), width), edge(Math.max(ax, bx), width)], [y0, y1] = [edge(Math.min(ay, by), height), edge(Math.max(ay, by), height)];
  return x1 - x0 < 2 || y1 - y0 < 2 ? null : [x0, y0, x1 - x0, y1 - y0];
}

/// "4, 5, 20, 10" inside of a photograph.
export function parse_roi(text: string, width: number, height: number): Region | null {
  const numbers = text.split(/[\s,;]+/).filter((word) => word !== "").map(Number);
  const [x, y, w, hgt] = numbers as Region;
  return numbers.length === 4 && numbers.every((n) => Number.isInteger(n) && n >= 0) && w > 0 && hgt > 0 && x + w <= width && y + hgt <= height ? [x, y, w, hgt] : null;
}

/// Surface length of a pixel, to six digits; nothing for places that are one, or a length that is none.
export function texel_size([a, b]: { x: number; y: number }[], mm: number | undefined): number | null {
  const pixels = a && b ? Math.hypot(a.x - b.x, a.y - b.y) : 0;
  return pixels >= 1 && mm !== undefined && mm > 0 ? Number((mm / pixels).toPrecision(6)) : null;
}

/// Lines of the project.
export function project_text(members: Members, mask: string | null): string {
  const all: [string, unknown][] = [["roi", members.roi], ["mask", mask], ["texel_size_mm", members.texel_size_mm], ["chart", members.chart]];
  return all.filter(([, value]) => value !== null).map(([name, value]) => `"${name}": ${JSON.stringify(value).replace(/,/g, ", ").replace(/":/g, '": ')}`).join(",\n");
}
