// The file itself, to be typed in, with what is wrong in it and where.

import { useEffect, useRef } from "preact/hooks";
import { Card } from "./Card";
import { hasUnsavedEdits } from "./history";
import { store, type AppState } from "./store";
import { t } from "./i18n";
import type { Problem } from "./types";

export function Editor({ known }: { known: AppState }) {
  const area = useRef<HTMLTextAreaElement>(null);
  const timer = useRef<ReturnType<typeof setTimeout>>(undefined);
  const last = useRef(0);
  const history = known.history;
  const text = history?.text ?? "";
  useEffect(() => {
    const element = area.current;
    if (element && element.value !== text && !timer.current) element.value = text;
  }, [text]);
  const commit = (): void => {
    if (timer.current === undefined) return;
    clearTimeout(timer.current);
    timer.current = undefined;
    const now = performance.now();
    if (area.current) store.type(area.current.value, now - last.current < 1500);
    last.current = now;
  };
  useEffect(() => {
    store.pending = commit;
    return () => { store.pending = null; };
  }, []);
  if (!history) return null;
  const go = (p: Problem): void => {
    const element = area.current;
    if (!element || !p.line) return;
    const lines = element.value.split("\n");
    const at = lines.slice(0, p.line - 1).reduce((sum, l) => sum + l.length + 1, 0) + p.column - 1;
    element.focus();
    element.setSelectionRange(at, at + 1);
    element.scrollTop = (p.line - 4) * 18;
  };
  const wrong = known.problems;
  const odd = known.live?.warnings ?? [];
  return (
    <Card id="editor" title={t("The file")} note={<>{known.files[known.file ?? 0]}{hasUnsavedEdits(history) ? ` · ${t("not saved")}` : ""}</>}>
      <textarea
        ref={area}
        aria-labelledby="editor"
        aria-invalid={wrong.length > 0}
        spellcheck={false}
        autocomplete="off"
        wrap="off"
        onInput={() => {
          clearTimeout(timer.current);
          timer.current = setTimeout(commit, 250);
        }}
        onBlur={commit}
      />
      {(wrong.length > 0 || odd.length > 0) && (
        <ul class="problems" aria-live="polite">
          {wrong.map((p, k) => <Wrong key={`w${k}`} of={p} kind="fail" go={go} />)}
          {odd.map((p, k) => <Wrong key={`o${k}`} of={p} kind="warn" go={go} />)}
        </ul>
      )}
    </Card>
  );
}

function Wrong({ of: p, kind, go }: { of: Problem; kind: string; go: (p: Problem) => void }) {
  return (
    <li class={kind}>
      <button class="link" onClick={() => go(p)}>{p.line ? `${p.line}:${p.column}` : t("file")}</button>{" "}
      {p.key && <code>{p.key}</code>} {p.message}
      {p.value && ` (${p.value})`}
      {p.hint && <i> {p.hint}</i>}
    </li>
  );
}
