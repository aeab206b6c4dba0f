// Writes the types of the server's answers, made/types.ts, from their JSON Schema.

import { mkdirSync, readFileSync, writeFileSync } from "node:fs";

const schema = new URL("../src/cardan/web/messages.schema.json", import.meta.url);
const { $defs } = JSON.parse(readFileSync(schema, "utf8"));

const bracketed = (said) => (/[|&]/.test(said) ? `(${said})` : said);

function typed(of) {
  if (of.$ref) return of.$ref.replace("#/$defs/", "");
  if (of.const !== undefined) return JSON.stringify(of.const);
  if (of.enum) return of.enum.map((v) => JSON.stringify(v)).join(" | ");
  if (of.anyOf) return of.anyOf.map(typed).join(" | ");
  if (of.allOf) return of.allOf.map((o) => bracketed(typed(o))).join(" & ");
  if (Array.isArray(of.type)) return of.type.join(" | ");
  if (of.type === "array" && of.prefixItems) return `[${of.prefixItems.map(typed).join(", ")}]`;
  if (of.type === "array") return `${bracketed(typed(of.items))}[]`;
  if (of.properties) return fields(of);
  if (of.additionalProperties) return `Record<${of.propertyNames ? typed(of.propertyNames) : "string"}, ${typed(of.additionalProperties)}>`;
  return of.type ?? "unknown";
}

function fields(of) {
  const said = Object.entries(of.properties).map(([name, value]) => {
    const note = value.description ? `/** ${value.description} */ ` : "";
    return `${note}${name}${of.required?.includes(name) ? "" : "?"}: ${typed(value)};`;
  });
  return `{ ${said.join(" ")} }`;
}

const made = Object.entries($defs).map(([name, of]) => {
  const note = of.description ? `/** ${of.description} */\n` : "";
  return of.properties ? `${note}export interface ${name} ${fields(of)}` : `${note}export type ${name} = ${typed(of)};`;
});
mkdirSync(new URL("made/", import.meta.url), { recursive: true });
writeFileSync(new URL("made/types.ts", import.meta.url), `// Made from messages.schema.json by types.mjs.\n\n${made.join("\n\n")}\n`);
