// Names and paths of files in the served folder.

/// As files may be called here: letters, digits and a few signs.
export function plain_name(name: string, fallback = "mesh"): string {
  const dot = name.lastIndexOf(".");
  const stem = (dot < 0 ? name : name.slice(0, dot)).replace(/[^A-Za-z0-9._-]+/g, "_").replace(/^[._]+|_+$/g, "").slice(0, 80);
  return (stem || fallback) + (dot < 0 ? "" : name.slice(dot).toLowerCase());
}

/// A path from the folder of one file to another.
export function relative_path(from: string, to: string): string {
  const a = from.split("/").slice(0, -1), b = to.split("/");
  let same = 0;
  while (same < a.length && same < b.length - 1 && a[same] === b[same]) ++same;
  return [...a.slice(same).map(() => ".."), ...b.slice(same)].join("/");
}
