/** The words of the page: English stands in the code, other languages in one dictionary. */

let dictionary: Record<string, string> = {};
const unknown = new Set<string>();
let speaks = false;

/** Speaks another language from now on; without a dictionary English. */
export function speak(words: Record<string, string> | null): void {
  speaks = words !== null;
  dictionary = words ?? {};
  unknown.clear();
}

/** A text in the language of the page; `{}` in it are replaced by the values in turn. */
export function say(text: string, ...values: (string | number)[]): string {
  const known = dictionary[text];
  if (speaks && known === undefined) unknown.add(text);
  let next = 0;
  return (known ?? text).replace(/\{\}/g, () => String(values[next++]));
}

/** Texts that were wanted and that the dictionary lacks, for tests. */
export const untranslated = (): string[] => [...unknown];
