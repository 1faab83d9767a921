// One stream for all tabs of this browser. Who holds the lock streams and repeats every batch on a BroadcastChannel; the
// others listen. One whose leader has been silent for some seconds takes the lock away and goes on from its own cursor; the
// old leader, when it wakes, notices that and listens too. A batch names the cursor that it follows: a tab that slept sees
// what it missed (live/stream.ts). Without locks (a page that is neither https nor loopback) each tab streams by itself.
import type { WatchResponse } from '@/api/gen/driftwise/v1/watch_service_pb';

const lockName = 'driftwise-stream-2'; // counts the versions of the messages: tabs of an older page have a leader of their own
const silentLeaderMs = 3500;
const answersWithinMs = 3000; // to a new leader, by its followers

export type TabMessage =
  | { kind: 'hello'; from: string } // a new tab asks for the present state
  | { kind: 'here'; from: string } // a follower's answer to `leading`
  | { kind: 'bye'; from: string } // a follower that closes
  | { kind: 'state'; to: string; batch: WatchResponse } // the answer to both where the leader does not know the tab yet
  | { kind: 'batch'; after: string; batch: WatchResponse } // after: the cursor that it follows
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
  private readonly name = Math.random().toString(36).slice(2);
  private readonly followers = new Set<string>(); // that this leader knows
  private ledSinceMs = 0;
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
    this.say({ kind: 'hello', from: this.name });
    addEventListener('pagehide', this.leave);
    this.timer = setInterval(() => this.everySecond(), 1000);
  }

  stop(): void {
    removeEventListener('pagehide', this.leave);
    this.leave();
    clearInterval(this.timer);
    this.queued?.abort();
    this.leading?.abort();
    this.channel?.close();
  }

  // A batch is copied for every listener and, without one, for nobody: only where there is one. A follower counts until it says
  // that it closes, however long it is silent: a page in the background may sleep, and must miss nothing.
  say(message: TabMessage): void {
    if (message.kind === 'batch' && !this.isHeard()) return;
    this.channel?.postMessage(message);
  }

  private isHeard(): boolean {
    return this.followers.size > 0 || performance.now() - this.ledSinceMs < answersWithinMs;
  }

  private readonly leave = (): void => {
    if (!this.isLeader) this.say({ kind: 'bye', from: this.name });
  }

  private heard(message: TabMessage): void {
    if (this.isLeader) {
      if (message.kind === 'bye') this.followers.delete(message.from);
      if (message.kind !== 'hello' && message.kind !== 'here') return;
      const batch = message.kind === 'hello' || !this.followers.has(message.from) ? this.role.state() : undefined;
      this.followers.add(message.from);
      if (batch) this.say({ kind: 'state', to: message.from, batch });
      return;
    }
    if (message.kind === 'hello' || message.kind === 'here' || message.kind === 'bye') return;
    this.heardAt = performance.now();
    if (message.kind === 'leading') this.say({ kind: 'here', from: this.name });
    if (message.kind !== 'state' || message.to === this.name) this.role.hear(message);
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
        this.followers.clear();
        this.ledSinceMs = performance.now();
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
