// A field of cells, coloured by what limits make of them; a hand or the arrow keys choose one.

import { useEffect, useRef } from "preact/hooks";
import { GRADES } from "./gradeLookup";
import type { Maybe } from "./types";
import { cssColour, useElementWidth } from "./hooks";

export function CellMap(of: {
  label: string;
  /** Edges of the columns and rows, in any unit: one more than cells. */
  x: number[];
  y: number[];
  /** By row and column: places in `among`; null where nothing is known. */
  grades: Maybe[][];
  among?: string[];
  /** 0 faint to 1 full, by row and column. */
  strength?: (row: number, column: number) => number;
  at: [number, number]; choose: (row: number, column: number) => void;
  said: string; height: number; theme: string;
  /** Whether the first row is drawn at the bottom. */
  up?: boolean;
}) {
  const [box, width] = useElementWidth(420);
  const canvas = useRef<HTMLCanvasElement>(null);
  const [rows, columns] = [of.y.length - 1, of.x.length - 1];
  const place = (edges: number[], size: number) => {
    const [low, high] = [edges[0] ?? 0, edges.at(-1) ?? 1];
    return (v: number): number => ((v - low) / (high - low || 1)) * size;
  };
  useEffect(() => {
    const c = canvas.current;
    const ctx = c?.getContext("2d");
    if (!c || !ctx) return;
    const ratio = devicePixelRatio;
    [c.width, c.height] = [width * ratio, of.height * ratio];
    const [px, py] = [place(of.x, c.width), place(of.y, c.height)];
    const fills = (of.among ?? GRADES).map((g) => cssColour(`--${g}`));
    const spot = (r: number, k: number): [number, number, number, number] => {
      const [x1, x2] = [px(of.x[k] ?? 0), px(of.x[k + 1] ?? 0)].map(Math.round) as [number, number];
      const [y1, y2] = [py(of.y[r] ?? 0), py(of.y[r + 1] ?? 0)].map(Math.round) as [number, number];
      return of.up ? [x1, c.height - y2, x2 - x1, y2 - y1] : [x1, y1, x2 - x1, y2 - y1];
    };
    ctx.fillStyle = cssColour("--sunk");
    ctx.fillRect(0, 0, c.width, c.height);
    of.grades.forEach((row, r) =>
      row.forEach((grade, k) => {
        if (grade === null) return;
        ctx.fillStyle = fills[grade] ?? "";
        ctx.globalAlpha = of.strength?.(r, k) ?? 0.75;
        const [x, y, w, h] = spot(r, k);
        ctx.fillRect(x, y, w, h);
      }),
    );
    ctx.globalAlpha = 1;
    ctx.lineWidth = 2 * ratio;
    ctx.strokeStyle = cssColour("--ink");
    const [x, y, w, h] = spot(...of.at);
    ctx.strokeRect(x, y, Math.max(w, 4), h);
  });
  const found = (edges: number[], size: number, at: number): number => {
    const p = place(edges, size);
    return Math.max(0, Math.min(edges.length - 2, edges.findIndex((_, k) => p(edges[k + 1] ?? Infinity) > at)));
  };
  const point = (e: PointerEvent): void => {
    if (e.type === "pointermove" && !(e.buttons & 1)) return;
    const b = (e.currentTarget as Element).getBoundingClientRect();
    const y = of.up ? b.bottom - e.clientY : e.clientY - b.top;
    of.choose(found(of.y, b.height, y), found(of.x, b.width, e.clientX - b.left));
  };
  const keyed = (e: KeyboardEvent): void => {
    const up = of.up ? 1 : -1;
    const by: Record<string, [number, number]> = { ArrowUp: [up, 0], ArrowDown: [-up, 0], ArrowLeft: [0, -1], ArrowRight: [0, 1] };
    const step = by[e.key];
    if (!step) return;
    e.preventDefault();
    of.choose(Math.max(0, Math.min(rows - 1, of.at[0] + step[0])), Math.max(0, Math.min(columns - 1, of.at[1] + step[1])));
  };
  return (
    <div class="field" ref={box}>
      <canvas
        ref={canvas}
        style={{ height: of.height }}
        tabindex={0}
        role="slider"
        aria-label={of.label}
        aria-valuenow={of.at[0] * columns + of.at[1]}
        aria-valuemin={0}
        aria-valuemax={rows * columns - 1}
        aria-valuetext={of.said}
        onPointerDown={point}
        onPointerMove={point}
        onKeyDown={keyed}
      />
      <p class="note" aria-live="polite">{of.said}</p>
    </div>
  );
}
