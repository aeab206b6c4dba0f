// Texts, by their English wording, in the language of the last welcome.

let texts: Record<string, string> = {};

export function setTexts(all: Record<string, string>): void { texts = all; }

export function t(said: string, values?: Record<string, string | number>): string {
  const found = texts[said] ?? said;
  return values ? found.replace(/\{(\w+)\}/g, (_, name: string) => String(values[name] ?? "")) : found;
}
