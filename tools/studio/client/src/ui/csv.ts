// Tables as files for spreadsheets and programs: RFC 4180, with a point in numbers.
import { download } from "./notices";

export interface Column {
  name: string;
  values: (number | string | null)[];
}

export function csv_text(columns: Column[]): string {
  const cell = (value: number | string | null | undefined): string => {
    if (value === null || value === undefined) return "";
    const text = typeof value === "number" ? (Number.isFinite(value) ? String(value) : "") : value;
    return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  const num_rows = Math.max(0, ...columns.map((c) => c.values.length));
  const rows = Array.from({ length: num_rows }, (_, i) => columns.map((c) => cell(c.values[i])).join(","));
  return `${columns.map((c) => cell(c.name)).join(",")}\n${rows.map((row) => `${row}\n`).join("")}`;
}

/// "height (mm)".
export function column_name(name: string, unit: string): string {
  return unit && unit !== "1" ? `${name} (${unit})` : name;
}

export function download_csv(columns: Column[], name: string): void {
  download(new Blob([csv_text(columns)], { type: "text/csv" }), name.replace(/[^\w.-]+/g, "_"));
}
