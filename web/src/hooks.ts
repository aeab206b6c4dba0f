// The store in a component, the size of an element, a hand on a handle.

import { h, type ComponentType, type JSX } from "preact";
import { useEffect, useMemo, useRef, useState } from "preact/hooks";
import { store, type AppState } from "./store";

export function useAppState(): AppState {
  const [known, set] = useState(store.known);
  useEffect(() => {
    set(store.known);
    return store.watch(() => set(store.known));
  }, []);
  return known;
}

/** A component that is drawn again only where something it depends on is another. */
export function memoised<P extends object>(of: ComponentType<P>, depends: (props: P) => unknown[]): (props: P) => JSX.Element {
  return (props) => useMemo(() => h(of as ComponentType, props) as JSX.Element, depends(props));
}

/** A card that is still, too: while a hand moves, out of sight it waits until it is let go or scrolled to. */
export function memoisedCard<P extends { known: AppState }>(id: string, of: ComponentType<P>, depends: (props: P) => unknown[]): (props: P) => JSX.Element {
  return (props) => {
    const [near, set] = useState(true);
    const last = useRef<unknown[]>([]);
    useEffect(() => {
      const watcher = new IntersectionObserver((seen) => set(seen.at(-1)?.isIntersecting ?? true), { rootMargin: "100px" });
      watcher.observe(document.getElementById(id)?.closest("section") ?? document.body);
      return () => watcher.disconnect();
    }, []);
    if (near || props.known.held === null) last.current = depends(props);
    return useMemo(() => h(of as ComponentType<object>, props) as JSX.Element, last.current);
  };
}

const kept = new Map<string, unknown>();

/** What a form holds: it is there again where its view comes back. */
export function useRetainedState<T>(key: string, first: T): [T, (now: T) => void] {
  const [value, set] = useState<T>((kept.get(key) as T | undefined) ?? first);
  return [value, (now) => { kept.set(key, now); set(now); }];
}

/** The width of an element, as it changes. */
export function useElementWidth(first: number): [(element: HTMLElement | null) => void, number] {
  const [width, set] = useState(first);
  const watcher = useRef<ResizeObserver | null>(null);
  const take = useRef((element: HTMLElement | null) => {
    watcher.current?.disconnect();
    if (!element) return;
    set(element.clientWidth || first);
    watcher.current = new ResizeObserver(() => set(element.clientWidth || first));
    watcher.current.observe(element);
  });
  return [take.current, width];
}

let probe: HTMLElement | null = null;

/** A colour of the page by its name, as it is now. */
export function cssColour(name: string): string {
  probe ??= document.body.appendChild(document.createElement("i"));
  probe.style.color = `var(${name})`;
  return getComputedStyle(probe).color;
}

export type DragHandlers = Record<"onPointerDown" | "onPointerMove" | "onPointerUp" | "onPointerCancel", (e: PointerEvent) => void> & { onKeyDown: (e: KeyboardEvent) => void; onBlur: () => void; onTouchStart: (e: TouchEvent) => void };

/** Steps of the keys, in millimetres or degrees. */
const STEPS = { fine: 0.1, one: 1, page: 10 };

/**
 * What moves a thing by pointer or keys.
 *
 * `moved` is told pixels from where the pointer went down; `stepped` how many units the keys
 * moved it in all, right and up. Keys let go after a rest, a pointer where it is lifted;
 * Escape puts it back.
 */
export function useDragHandlers(of: {
  moved: (dx: number, dy: number) => void;
  stepped: (right: number, up: number) => void;
  release: () => void;
  cancel: () => void;
}): DragHandlers {
  const down = useRef<{ x: number; y: number; id: number } | null>(null);
  const keys = useRef<{ right: number; up: number; timer: ReturnType<typeof setTimeout> } | null>(null);
  const latest = useRef(of);
  latest.current = of;

  const rest = (): void => {
    if (!keys.current) return;
    clearTimeout(keys.current.timer);
    keys.current = null;
    latest.current.release();
  };
  const hand = useRef<DragHandlers>({
    onPointerDown: (e) => {
      if (e.button !== 0) return;
      rest();
      down.current = { x: e.clientX, y: e.clientY, id: e.pointerId };
      (e.currentTarget as Element).setPointerCapture(e.pointerId);
      (e.currentTarget as HTMLElement | SVGElement).focus({ preventScroll: true });
      e.preventDefault();
    },
    onPointerMove: (e) => {
      const from = down.current;
      if (from?.id === e.pointerId) latest.current.moved(e.clientX - from.x, e.clientY - from.y);
    },
    onPointerUp: (e) => {
      if (down.current?.id !== e.pointerId) return;
      down.current = null;
      latest.current.release();
    },
    onPointerCancel: (e) => {
      if (down.current?.id !== e.pointerId) return;
      down.current = null;
      latest.current.cancel();
    },
    onKeyDown: (e) => {
      if (e.key === "Escape") {
        down.current = null;
        if (keys.current) clearTimeout(keys.current.timer);
        keys.current = null;
        latest.current.cancel();
        return;
      }
      const size = e.shiftKey ? STEPS.fine : STEPS.one;
      const by: Record<string, [number, number]> = { ArrowUp: [0, size], ArrowDown: [0, -size], ArrowRight: [size, 0], ArrowLeft: [-size, 0], PageUp: [0, STEPS.page], PageDown: [0, -STEPS.page] };
      const step = by[e.key];
      if (e.key === "Enter") rest();
      if (!step || e.ctrlKey || e.metaKey || e.altKey) return;
      e.preventDefault();
      const was = keys.current ?? { right: 0, up: 0, timer: setTimeout(() => undefined, 0) };
      clearTimeout(was.timer);
      const now = { right: was.right + step[0], up: was.up + step[1], timer: setTimeout(rest, 600) };
      keys.current = now;
      latest.current.stepped(now.right, now.up);
    },
    onBlur: rest,
    // `touch-action` does not hold for what lies in a drawing: the page would scroll, and take the hand away.
    onTouchStart: (e) => e.preventDefault(),
  });
  return hand.current;
}
