// Turns the view a little as a phone or tablet is tilted, like a window that one looks through from
// another side. The pose that the device is held in becomes the middle within seconds.

const kShare = 0.6; // Of the device's angle.
const kMostRadians = 0.5;
const kRecentreSeconds = 8;

export class Tilt {
  // Angles by which the eye turns around the middle of the room, in radians.
  right = 0;
  down = 0;
  private middle: { x: number; y: number } | null = null;
  private lastAt = 0;

  constructor(private readonly changed: () => void) {}

  // Whether this device may have a gyroscope. Computers have the event, too, but never send it.
  static get isOffered(): boolean {
    return typeof DeviceOrientationEvent !== 'undefined' && matchMedia('(pointer: coarse)').matches;
  }

  // Call it from a click: iOS asks the person. Returns false if the person refuses.
  async start(): Promise<boolean> {
    const event = DeviceOrientationEvent as unknown as { requestPermission?: () => Promise<string> };
    if (event.requestPermission && (await event.requestPermission()) !== 'granted') return false;
    window.addEventListener('deviceorientation', this.onOrientation);
    return true;
  }

  stop(): void {
    window.removeEventListener('deviceorientation', this.onOrientation);
    this.middle = null;
    this.right = this.down = 0;
    this.changed();
  }

  private readonly onOrientation = ({ beta, gamma, timeStamp }: DeviceOrientationEvent): void => {
    if (beta === null || gamma === null) return;
    // Angles about the screen's axes as the person holds it.
    const turn = ((screen.orientation?.angle ?? 0) * Math.PI) / 180;
    const x = gamma * Math.cos(turn) + beta * Math.sin(turn), y = beta * Math.cos(turn) - gamma * Math.sin(turn);
    this.middle ??= { x, y };
    const follow = Math.min((timeStamp - this.lastAt) / 1000 / kRecentreSeconds, 1) * (this.lastAt > 0 ? 1 : 0);
    this.lastAt = timeStamp;
    this.middle.x += (x - this.middle.x) * follow;
    this.middle.y += (y - this.middle.y) * follow;
    const angle = (degrees: number) =>
      Math.min(Math.max((degrees * kShare * Math.PI) / 180, -kMostRadians), kMostRadians);
    this.right = angle(x - this.middle.x);
    this.down = angle(y - this.middle.y);
    this.changed();
  };
}
