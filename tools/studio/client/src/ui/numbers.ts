// Numbers as people read and write them.

export function number_text(value: number, digits = 3): string {
  if (!Number.isFinite(value)) return "-";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) return value.toExponential(1);
  return String(size >= 10 ** digits ? Math.round(value) : Number(value.toPrecision(digits)));
}

/// "0.5", "0,5", "1e-3"; nothing for what is no number.
export function parse_number(text: string): number | undefined {
  const plain = text.trim().replace(",", ".").replace("\u2212", "-");
  const value = Number(plain);
  return plain === "" || !Number.isFinite(value) ? undefined : value;
}

let next_id = 0;
/// Of an element that a label names.
export const unique_id = (): string => `c${next_id++}`;
