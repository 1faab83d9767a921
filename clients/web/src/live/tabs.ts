// One stream for all tabs of this browser. Who holds the lock streams and repeats every batch on a BroadcastChannel; the
// others listen. One whose leader has been silent for some seconds takes the lock away and goes on from its own cursor; the
// old leader, when it wakes, notices that and listens too. Without locks (a page that is neither https nor loopback)
// each tab streams by itself.
import type { WatchResponse } from '@/api/gen/driftwise/v1/watch_service_pb';

const lockName = 'driftwise-stream';
const silentLeaderMs = 3500;

export type TabMessage =
  | { kind: 'hello' } // a new tab asks for the present state
  | { kind: 'state'; batch: WatchResponse } // the answer to it
  | { kind: 'batch'; batch: WatchResponse }
  | { kind: 'afresh' }
  | { kind: 'leading' }; // once a second, also while the daemon does not answer

export interface TabRole {
  lead: (signal: AbortSignal) => Promise<void>; // streams until the signal
  hear: (message: TabMessage) => void; // follower: what the leader repeats
  state: () => WatchResponse | undefined; // leader: what a new tab needs
}

export class Tabs {
  private readonly channel = typeof BroadcastChannel === 'undefined' ? undefined : new BroadcastChannel(lockName);
  private readonly locks: LockManager | undefined = this.channel && navigator.locks;
  private leading: AbortController | undefined;
  private queued: AbortController | undefined;
  private heardAt = performance.now();
  private timer: ReturnType<typeof setInterval> | undefined;
  private readonly jitterMs = Math.random() * 500; // so that not all followers reach for the lock at once

  constructor(private readonly role: TabRole) {}

  get isLeader(): boolean {
    return this.leading !== undefined;
  }

  start(): void {
    if (!this.locks || !this.channel) {
      this.leading = new AbortController();
      void this.role.lead(this.leading.signal);
      return;
    }
    this.channel.onmessage = (event: MessageEvent<TabMessage>) => this.heard(event.data);
    this.queue();
    this.say({ kind: 'hello' });
    this.timer = setInterval(() => this.everySecond(), 1000);
  }

  stop(): void {
    clearInterval(this.timer);
    this.queued?.abort();
    this.leading?.abort();
    this.channel?.close();
  }

  say(message: TabMessage): void {
    this.channel?.postMessage(message);
  }

  private heard(message: TabMessage): void {
    if (this.isLeader) {
      const batch = message.kind === 'hello' ? this.role.state() : undefined;
      if (batch) this.say({ kind: 'state', batch });
      return;
    }
    if (message.kind === 'hello') return;
    this.heardAt = performance.now();
    this.role.hear(message);
  }

  private everySecond(): void {
    if (this.isLeader) this.say({ kind: 'leading' });
    else if (performance.now() - this.heardAt > silentLeaderMs + this.jitterMs) this.steal();
  }

  private queue(): void {
    const waiting = (this.queued = new AbortController());
    this.hold({ signal: waiting.signal });
  }

  private steal(): void {
    this.heardAt = performance.now();
    this.queued?.abort();
    this.hold({ steal: true });
  }

  private hold(options: LockOptions): void {
    this.locks!
      .request(lockName, options, async () => {
        const term = (this.leading = new AbortController());
        this.say({ kind: 'leading' });
        await this.role.lead(term.signal);
      })
      .catch(() => {
        if (options.signal?.aborted) return; // this one reached for the lock in another way
        this.leading?.abort(); // taken away: another tab streams now
        this.leading = undefined;
        this.heardAt = performance.now();
        this.queue();
      });
  }
}
