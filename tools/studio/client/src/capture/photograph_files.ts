// Which of the files that were chosen or dropped are photographs, and what they are called in the served folder.
import { plain_name } from "../build/paths";

/// Of files whose type a browser does not know: what else `init` takes.
const kOther = /\.(3fr|arw|cr2|cr3|dng|erf|exr|heic|heif|hif|jp2|kdc|mpo|mrw|nef|nrw|orf|pef|pgm|ppm|psd|raf|raw|rw2|rwl|sr2|srf|srw|tga|tiff?|x3f)$/i;
export const kPhotographs = "image/*,video/*,.arw,.cr2,.cr3,.dng,.exr,.heic,.nef,.orf,.raf,.rw2,.tga,.tif";

export interface ChosenFile {
  file: File;
  /// "day1/IMG_1.jpg", of a folder that was chosen or dropped.
  path: string;
}

export function is_photograph({ name, type }: { name: string; type: string }): boolean {
  if (name.startsWith(".")) return false;
  return kOther.test(name) || (/^(image|video)\//.test(type) && !type.includes("svg"));
}

/// A name for each, no two the same whatever the case of letters: with its folder's name where others have its own.
export function photograph_names(files: readonly ChosenFile[]): string[] {
  const own = files.map(({ file }) => plain_name(file.name, "photograph"));
  const count = (names: string[], name: string): number => names.filter((other) => other.toLowerCase() === name.toLowerCase()).length;
  const longer = files.map(({ path }, i) => (count(own, own[i]!) === 1 ? own[i]! : plain_name(path.split("/").slice(-2).join("_"), "photograph")));
  const used = new Set<string>();
  return longer.map((name) => {
    const dot = name.lastIndexOf(".");
    let free = name;
    for (let k = 2; used.has(free.toLowerCase()); ++k) free = `${name.slice(0, dot)}_${k}${name.slice(dot)}`;
    used.add(free.toLowerCase());
    return free;
  });
}
