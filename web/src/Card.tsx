// A part of the page under its heading.

import type { ComponentChildren } from "preact";

/** A section that is called by its heading; beside that stand a note and what asks for it. */
export function Card({ id, kind = id, title, note, head, children }: { id: string; kind?: string; title: ComponentChildren; note?: ComponentChildren; head?: ComponentChildren; children?: ComponentChildren }) {
  return (
    <section class={`card ${kind}`} aria-labelledby={id}>
      <header><h2 id={id}>{title}</h2>{note !== undefined && <span class="note">{note}</span>}{head}</header>
      {children}
    </section>
  );
}
