// The words and buttons around the view.

import { Camera } from './camera';
import { Unseen } from './renderer/renderer';

const element = <T extends HTMLElement>(id: string) => document.getElementById(id) as T;
const kIdleAfterMs = 4000; // The buttons fade so long after the last movement.
const kUnseen: { value: Unseen; words: string }[] = [
  { value: 'extend', words: 'Unseen: extended' },
  { value: 'dim', words: 'Unseen: dimmed' },
  { value: 'black', words: 'Unseen: black' },
];

export interface Commands {
  reset(): void;
  redraw(): void;
  setTilt(isOn: boolean): Promise<boolean>; // Returns whether it is on.
  enterHeadset(): void;
}

export class Panel {
  private unseenIndex = 0;
  private idleTimer = 0;

  constructor(commands: Commands) {
    const help = element<HTMLDialogElement>('help');
    const toggleUnseen = () => {
      this.unseenIndex = (this.unseenIndex + 1) % kUnseen.length;
      element('unseen').textContent = kUnseen[this.unseenIndex]!.words;
      commands.redraw();
    };
    const toggleNumbers = () => {
      const numbers = element('numbers');
      numbers.hidden = !numbers.hidden;
      element('show-numbers').ariaPressed = String(!numbers.hidden);
    };
    const toggleFullScreen = () => {
      if (document.fullscreenElement) void document.exitFullscreen();
      else void document.documentElement.requestFullscreen();
    };
    const toggleTilt = async () => {
      const button = element('tilt');
      button.ariaPressed = String(await commands.setTilt(button.ariaPressed !== 'true'));
    };
    const byKey: Record<string, () => void> = {
      r: commands.reset, Home: commands.reset, u: toggleUnseen, n: toggleNumbers, f: toggleFullScreen,
      '?': () => help.showModal(),
    };
    const byButton: Record<string, () => void> = {
      reset: commands.reset, unseen: toggleUnseen, 'show-numbers': toggleNumbers, 'full-screen': toggleFullScreen,
      'show-help': () => help.showModal(), 'close-help': () => help.close(), share: () => void share(),
      tilt: () => void toggleTilt(), headset: commands.enterHeadset,
    };
    for (const [id, action] of Object.entries(byButton)) element(id).addEventListener('click', action);
    window.addEventListener('keydown', (event) => {
      const action = byKey[event.key.length === 1 ? event.key.toLowerCase() : event.key];
      if (!action || help.open || event.ctrlKey || event.altKey || event.metaKey) return;
      event.preventDefault();
      action();
    });
    element('full-screen').hidden = !document.fullscreenEnabled;
    for (const name of ['pointermove', 'pointerdown', 'keydown']) window.addEventListener(name, () => this.wake());
    this.wake();
  }

  get unseen(): Unseen {
    return kUnseen[this.unseenIndex]!.value;
  }
  get showsNumbers(): boolean {
    return !element('numbers').hidden;
  }

  offer(button: 'tilt' | 'headset'): void {
    element(button).hidden = false;
  }

  // Shows a sentence in the middle, or above the view if one is shown. Empty hides it.
  say(sentence: string, isOverView: boolean): void {
    const message = element('message');
    if (message.textContent !== sentence) message.textContent = sentence;
    message.classList.toggle('overlaid', isOverView);
  }

  // Lists the cameras that show nothing new, and why.
  showNotes(notes: string[]): void {
    const list = element('notes');
    if ([...list.children].map((item) => item.textContent).join('\n') === notes.join('\n')) return;
    list.replaceChildren(...notes.map((note) => Object.assign(document.createElement('li'), { textContent: note })));
  }

  showNumbers(rows: [string, string][]): void {
    element('numbers').replaceChildren(...rows.map(([name, value]) => {
      const row = document.createElement('tr');
      row.append(Object.assign(document.createElement('th'), { textContent: name }),
                 Object.assign(document.createElement('td'), { textContent: value }));
      return row;
    }));
  }

  private wake(): void {
    const nav = document.querySelector('nav')!;
    nav.classList.remove('idle');
    clearTimeout(this.idleTimer);
    this.idleTimer = window.setTimeout(() => nav.classList.add('idle'), kIdleAfterMs);
  }
}

// Why a camera shows nothing new, or nothing if it does.
export function noteOf(camera: Camera): string {
  if (camera.problem) return `${camera.name}: ${camera.problem}. The operator can choose another --codec.`;
  if (camera.state === 'connected' && camera.shown && camera.opacity() > 0) return '';
  const state = {
    connecting: 'connecting', connected: 'waiting for its first frame', waiting: 'waiting', failed: 'ended',
  };
  const stale = camera.state === 'connected' && camera.shown ? 'sends no frames' : state[camera.state];
  return `${camera.name}: ${camera.text || stale}`;
}

async function share(): Promise<void> {
  const button = element('share');
  try {
    if (navigator.share) await navigator.share({ title: document.title, url: location.href });
    else {
      await navigator.clipboard.writeText(location.href);
      button.textContent = 'Link copied';
      setTimeout(() => (button.textContent = 'Share'), 2000);
    }
  } catch {
    // The person closed the dialog.
  }
}
