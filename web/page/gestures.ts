// Mouse, touch and keyboard on the canvas. One finger or the left button orbits; two fingers or
// another button pan; two fingers and the wheel zoom; a double click or double tap focuses.

import { OrbitView } from './orbit_view';

const kKeyStep = 0.04; // Of the view's height.
const kPixelsPerNotch = 100; // Of a wheel.
const kDoubleTapMs = 350, kTapPixels = 12;

export interface Actions {
  moved(): void;
  focusAt(x: number, y: number): void; // In CSS pixels of the canvas.
}

export function followGestures(canvas: HTMLCanvasElement, view: OrbitView, actions: Actions): void {
  const pointers = new Map<number, { x: number; y: number }>();
  let lastTap = { at: -Infinity, x: 0, y: 0 };

  canvas.addEventListener('pointerdown', (event) => {
    canvas.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
    if (event.pointerType !== 'touch' || pointers.size > 1) return;
    const isDouble = event.timeStamp - lastTap.at < kDoubleTapMs &&
                     Math.hypot(event.clientX - lastTap.x, event.clientY - lastTap.y) < kTapPixels;
    lastTap = { at: isDouble ? -Infinity : event.timeStamp, x: event.clientX, y: event.clientY };
    if (isDouble) actions.focusAt(event.offsetX, event.offsetY);
  });
  for (const name of ['pointerup', 'pointercancel'] as const)
    canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));

  canvas.addEventListener('pointermove', (event) => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const now = { x: event.clientX, y: event.clientY };
    const other = [...pointers].find(([id]) => id !== event.pointerId)?.[1];
    pointers.set(event.pointerId, now);
    const right = (now.x - before.x) / canvas.clientHeight, down = (now.y - before.y) / canvas.clientHeight;
    if (other) {
      // Each finger moves the middle by half of its way.
      view.pan(right / 2, down / 2);
      const apartBefore = Math.hypot(before.x - other.x, before.y - other.y);
      const apart = Math.hypot(now.x - other.x, now.y - other.y);
      if (apartBefore > 0 && apart > 0) view.zoom(Math.log(apartBefore / apart) / Math.log(0.9));
    } else if (event.buttons === 1 && !event.shiftKey) {
      view.orbit(right, down);
    } else {
      view.pan(right, down);
    }
    actions.moved();
  });

  canvas.addEventListener('wheel', (event) => {
    event.preventDefault();
    const pixels = event.deltaMode === WheelEvent.DOM_DELTA_PIXEL ? event.deltaY : event.deltaY * 33;
    view.zoom(-pixels / kPixelsPerNotch);
    actions.moved();
  }, { passive: false });
  canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  canvas.addEventListener('dblclick', (event) => actions.focusAt(event.offsetX, event.offsetY));

  window.addEventListener('keydown', (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const move = event.shiftKey ? view.pan.bind(view) : view.orbit.bind(view);
    switch (event.key) {
      case 'ArrowLeft': move(-kKeyStep, 0); break;
      case 'ArrowRight': move(kKeyStep, 0); break;
      case 'ArrowUp': move(0, -kKeyStep); break;
      case 'ArrowDown': move(0, kKeyStep); break;
      case '+': case '=': view.zoom(1); break;
      case '-': view.zoom(-1); break;
      default: return;
    }
    event.preventDefault();
    actions.moved();
  });
}
