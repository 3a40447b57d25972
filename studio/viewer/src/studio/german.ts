/** The words of the page in German. */

export const GERMAN: Record<string, string> = {};
