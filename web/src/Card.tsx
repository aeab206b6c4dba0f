// A part of the page under its heading.

import type { ComponentChild, ComponentChildren } from "preact";
import { useId } from "preact/hooks";

/** A section that is called by its heading; beside that stand a note and what asks for it. */
export function Card({ id: given, kind = given, title, note, head, children }: { id?: string; kind?: string; title: ComponentChildren; note?: ComponentChildren; head?: ComponentChildren; children?: ComponentChildren }) {
  const own = useId();
  const id = given ?? own;
  return (
    <section class={`card ${kind}`} aria-labelledby={id}>
      <header><h2 id={id}>{title}</h2>{note !== undefined && <span class="note">{note}</span>}{head}</header>
      {children}
    </section>
  );
}

type Head = ComponentChild | [ComponentChild];

/** A table that scrolls by itself, under heads in their order: those of numbers each in a list. */
export function DataTable({ label, head, children }: { label: string; head: Head[]; children?: ComponentChildren }) {
  return (
    <div class="scroll" tabindex={0} role="region" aria-label={label}>
      <table class="rows">
        <thead><tr>{head.map((h, k) => h === "" ? <td key={k} /> : <th key={k} scope="col" class={Array.isArray(h) ? "n" : ""}>{h}</th>)}</tr></thead>
        <tbody>{children}</tbody>
      </table>
    </div>
  );
}

/** A choice among names; where one is not what it is called, beside what it is called. */
export function Select({ label, value, of, choose, ...rest }: { label?: string; value: string; of: readonly (string | readonly [string, string])[]; choose: (value: string) => void; [data: `data-${string}`]: string }) {
  return (
    <select aria-label={label} value={value} onChange={(e) => choose(e.currentTarget.value)} {...rest}>
      {of.map((o) => (typeof o === "string" ? [o, o] as const : o)).map(([one, said]) => <option key={one} value={one}>{said}</option>)}
    </select>
  );
}
