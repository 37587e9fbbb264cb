// Which of the files that were chosen or dropped are photographs, and what they are called in the served folder.
import { plain_name } from "../build/paths";

/// What the server takes.
const kEnds = "3fr 3g2 3gp arw avi avif bay bmp cap cr2 cr3 crw dc2 dcr dng dsc erf exr f4v fff gif heic heif iiq jp2 jpeg jpg k25 kc2 kdc m2v m4v mdc mef mj2 mkv mos mov mp4 mpe mpeg mpg mpo mrw nef nrw ogv orf pef pgm png ppm psd ptx pxn qt qtk raf raw rw2 rwl sr2 srf srw tga tif tiff vob webm webp wmv x3f".split(" ");
export const kPhotographs = `image/*,video/*,${kEnds.map((end) => `.${end}`).join()}`;

export interface ChosenFile {
  file: File;
  /// "day1/IMG_1.jpg", of a folder that was chosen or dropped.
  path: string;
}

export function is_photograph(name: string): boolean {
  return /^[^.].*\./.test(name) && kEnds.includes(name.slice(name.lastIndexOf(".") + 1).toLowerCase());
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
