// Counts frames and measures times, for copresence.stats() and the panel of numbers. The names are
// those of render_client --stats.

import { FrameHead } from './messages';
import { Shares } from './renderer/renderer';

// The last values of a quantity.
class Samples {
  private readonly values: number[] = [];
  private next = 0;

  constructor(private readonly most = 2000) {}

  add(value: number): void {
    if (this.values.length < this.most) this.values.push(value);
    else this.values[this.next] = value;
    this.next = (this.next + 1) % this.most;
  }

  percentiles(...percents: number[]): Record<string, number> {
    const sorted = [...this.values].sort((a, b) => a - b);
    const last = sorted.length - 1;
    const at = (percent: number) => sorted[Math.min(Math.floor((sorted.length * percent) / 100), last)] ?? 0;
    return Object.fromEntries(percents.map((percent) => [`p${percent}`, at(percent)]));
  }
}

const kStages = ['capture', 'fill', 'depth_encode', 'video_encode', 'wire', 'video_decode', 'depth_decode'] as const;
type Stage = (typeof kStages)[number];
const kRateSeconds = 2; // The panel shows means over this time.

export class CameraStatistics {
  private last: FrameHead['counters'] | null = null;
  private captured = 0;
  private encoderBusy = 0;
  private windowFull = 0;
  private received = 0;
  private decoded = 0;
  private undecodable = 0;
  private shown = 0;
  private newestDecoded = 0;
  private lastShown = 0;
  private bytes = 0;
  private firstAt = 0;
  private newestAt = 0;
  private connections = 0;
  private readonly latency = new Samples();
  private readonly stages =
    Object.fromEntries(kStages.map((stage) => [stage, new Samples()])) as Record<Stage, Samples>;
  private recent: { at: number; bytes: number }[] = [];

  connected(): void {
    ++this.connections;
    this.last = null;
  }

  // `at` is in microseconds on the page's clock, `wireMs` since the frame was sent.
  frameReceived(head: FrameHead, bytes: number, at: number, wireMs: number | null): void {
    const totals = head.counters;
    if (this.last && totals.captured > this.last.captured) {
      this.captured += totals.captured - this.last.captured;
      this.encoderBusy += totals.encoder_busy - this.last.encoder_busy;
      this.windowFull += totals.window_full - this.last.window_full;
    } else {
      ++this.captured;
    }
    this.last = totals;
    ++this.received;
    if (this.firstAt === 0) this.firstAt = at;
    else this.bytes += bytes;
    this.newestAt = at;
    this.recent.push({ at, bytes });
    while (this.recent[0]!.at < at - kRateSeconds * 1e6) this.recent.shift();
    for (const stage of ['capture', 'fill', 'depth_encode', 'video_encode'] as const)
      this.stages[stage].add(head.stages[stage] / 1000);
    if (wireMs !== null) this.stages.wire.add(wireMs);
  }

  frameDecoded(sequence: number, videoMs: number, depthMs: number): void {
    ++this.decoded;
    this.newestDecoded = sequence;
    this.stages.video_decode.add(videoMs);
    this.stages.depth_decode.add(depthMs);
  }

  frameUndecodable(): void {
    ++this.undecodable;
  }

  frameShown(sequence: number, latencyMs: number | null): void {
    ++this.shown;
    this.lastShown = sequence;
    if (latencyMs !== null) this.latency.add(latencyMs);
  }

  // Means over the last seconds; `now` is in microseconds.
  rates(now: number): { mbps: number; fps: number; latencyMs: number } {
    const recent = this.recent.filter(({ at }) => at > now - kRateSeconds * 1e6);
    return {
      mbps: (recent.reduce((sum, { bytes }) => sum + bytes, 0) * 8e-6) / kRateSeconds,
      fps: recent.length / kRateSeconds,
      latencyMs: this.latency.percentiles(50)['p50']!,
    };
  }

  report(name: string): object {
    const missing = this.captured - Math.min(this.captured, this.received);
    const known = this.encoderBusy + this.windowFull;
    const seconds = (this.newestAt - this.firstAt) * 1e-6;
    return {
      name,
      connections: this.connections,
      frames_captured: this.captured,
      frames_received: this.received,
      frames_decoded: this.decoded,
      frames_dropped: missing + this.undecodable,
      drops: {
        encoder_busy: this.encoderBusy,
        window_full: this.windowFull,
        decode_error: this.undecodable,
        unaccounted: missing - Math.min(missing, known),
      },
      frames_shown: this.shown,
      frames_unshown: Math.max(0, this.decoded - this.shown - (this.newestDecoded > this.lastShown ? 1 : 0)),
      last_shown_sequence: this.lastShown,
      mbps: seconds > 0 ? (this.bytes * 8e-6) / seconds : 0,
      latency_ms: this.latency.percentiles(50, 95, 99),
      stages_ms: Object.fromEntries(kStages.map((stage) => [stage, this.stages[stage].percentiles(50, 95)])),
    };
  }
}

export class ViewStatistics {
  private frames = 0;
  private firstAt = 0;
  private lastAt = 0;
  private readonly renderTime = new Samples();
  private readonly skew = new Samples();
  private recent: number[] = [];

  // Counts views from the first that shows every camera. Times are in microseconds.
  drawn(begin: number, end: number, isComplete: boolean, skewMs: number | null): void {
    this.recent = [...this.recent.filter((at) => at > end - kRateSeconds * 1e6), end];
    if (this.frames === 0) {
      if (!isComplete) return;
      this.firstAt = end;
    }
    ++this.frames;
    this.lastAt = end;
    this.renderTime.add((end - begin) / 1000);
    if (skewMs !== null) this.skew.add(skewMs);
  }

  fps(now: number): number {
    return this.recent.filter((at) => at > now - kRateSeconds * 1e6).length / kRateSeconds;
  }
  get skewMs(): number {
    return this.skew.percentiles(50)['p50']!;
  }

  report(width: number, height: number, shares: Shares | null): object {
    return {
      frames: this.frames,
      fps: this.frames > 1 ? (this.frames - 1) / ((this.lastAt - this.firstAt) * 1e-6) : 0,
      render_ms: this.renderTime.percentiles(50, 95),
      skew_ms: this.skew.percentiles(50, 95, 99),
      renderer: 'webgl2',
      size: `${width}x${height}`,
      ...(shares ? { shares } : {}),
    };
  }
}
