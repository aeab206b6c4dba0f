// Texts, by their English wording, in the language of the last welcome.

let texts: Record<string, string> = {};

export function learn(all: Record<string, string>): void { texts = all; }

export function t(said: string, values?: Record<string, string | number>): string {
  const found = texts[said] ?? said;
  if (!values) return found;
  return found.replace(/\{(\w+)\}/g, (_, name: string) => String(values[name] ?? ""));
}
