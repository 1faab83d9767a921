// Locks and channel of one browser, by hand: who leads, what the others hear, what happens when a leader goes or hangs.
import { create } from '@bufbuild/protobuf';
import { afterEach, beforeEach, describe, expect, it, vi } from 'vitest';
import { WatchResponseSchema, type WatchResponse } from '@/api/gen/driftwise/v1/watch_service_pb';
import { Tabs, type TabMessage } from '@/live/tabs';

type Holder = { reject: (error: Error) => void };

class OneLock {
  holder: Holder | undefined;
  queue: { run: () => void; signal?: AbortSignal }[] = [];
  request(_name: string, options: LockOptions, act: () => Promise<void>): Promise<void> {
    return new Promise((done, fail) => {
      const run = () => {
        const me: Holder = { reject: fail };
        this.holder = me;
        void act().then(() => {
          if (this.holder === me) this.next();
          done();
        });
      };
      if (options.steal) {
        this.holder?.reject(new DOMException('stolen', 'AbortError'));
        run();
      } else if (this.holder) {
        this.queue.push({ run, signal: options.signal });
        options.signal?.addEventListener('abort', () => fail(new DOMException('aborted', 'AbortError')));
      } else run();
    });
  }
  next(): void {
    this.holder = undefined;
    const waiting = this.queue.shift();
    if (!waiting) return;
    if (waiting.signal?.aborted) this.next();
    else waiting.run();
  }
}

const channels = new Set<FakeChannel>();
class FakeChannel {
  onmessage: ((event: { data: TabMessage }) => void) | null = null;
  constructor() {
    channels.add(this);
  }
  postMessage(data: TabMessage): void {
    for (const other of channels) if (other !== this) other.onmessage?.({ data });
  }
  close(): void {
    channels.delete(this);
  }
}

class Tab {
  heard: string[] = [];
  led = 0;
  stop: (() => void) | undefined;
  tabs: Tabs;
  constructor(private readonly name: string) {
    this.tabs = new Tabs({
      lead: (signal) => {
        this.led++;
        return new Promise((done) => {
          this.stop = done;
          signal.addEventListener('abort', () => done());
        });
      },
      hear: (message) => this.heard.push(message.kind),
      state: () => this.batch(),
    });
    this.tabs.start();
  }
  batch(): WatchResponse {
    return create(WatchResponseSchema, { cursor: this.name });
  }
}

beforeEach(() => {
  vi.useFakeTimers();
  channels.clear();
  vi.stubGlobal('BroadcastChannel', FakeChannel);
  const lock = new OneLock();
  vi.stubGlobal('navigator', { locks: { request: (name: string, options: LockOptions, act: () => Promise<void>) => lock.request(name, options, act) } });
});
afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe('tabs of one browser', () => {
  it('have one leader; a new one is given the state and hears every batch', async () => {
    const first = new Tab('first');
    const second = new Tab('second');
    expect([first.led, second.led]).toEqual([1, 0]);
    expect(second.heard).toContain('state');
    first.tabs.say({ kind: 'batch', after: '', batch: first.batch() });
    expect(second.heard).toContain('batch');
  });
  it('copy no batch for nobody: not before another tab is there, nor after the last one has closed', async () => {
    const first = new Tab('first');
    await vi.advanceTimersByTimeAsync(5000);
    const posted = vi.spyOn(FakeChannel.prototype, 'postMessage');
    const batches = () => posted.mock.calls.filter(([message]) => message.kind === 'batch').length;
    first.tabs.say({ kind: 'batch', after: '', batch: first.batch() });
    expect(batches()).toBe(0);
    const second = new Tab('second');
    first.tabs.say({ kind: 'batch', after: '', batch: first.batch() });
    expect(batches()).toBe(1);
    second.tabs.stop();
    first.tabs.say({ kind: 'batch', after: '', batch: first.batch() });
    expect(batches()).toBe(1);
    posted.mockRestore();
  });
  it('are known to a leader that took over, however long they are silent', async () => {
    const first = new Tab('first');
    const second = new Tab('second');
    const third = new Tab('third');
    first.stop!();
    await vi.advanceTimersByTimeAsync(60_000);
    third.heard.length = 0;
    second.tabs.say({ kind: 'batch', after: '', batch: second.batch() });
    expect([second.tabs.isLeader, third.heard]).toEqual([true, ['batch']]);
  });
  it('give a leader that was put to sleep the present state when it wakes, and no other tab', async () => {
    const first = new Tab('first');
    const second = new Tab('second');
    const third = new Tab('third');
    const say = vi.spyOn(first.tabs, 'say').mockImplementation(() => undefined); // it sleeps
    await vi.advanceTimersByTimeAsync(6000);
    const [leader, other] = second.tabs.isLeader ? [second, third] : [third, second];
    expect(leader.tabs.isLeader).toBe(true);
    first.heard.length = other.heard.length = 0;
    say.mockRestore();
    await vi.advanceTimersByTimeAsync(2000);
    expect(first.heard).toContain('state');
    expect(other.heard).not.toContain('state');
  });
  it('go on with the next when the leader is closed', async () => {
    const first = new Tab('first');
    const second = new Tab('second');
    first.stop!();
    await vi.advanceTimersByTimeAsync(10);
    expect(second.led).toBe(1);
  });
  it('take the lock from a leader that is silent for four seconds, and it steps down', async () => {
    const first = new Tab('first');
    const second = new Tab('second');
    const say = vi.spyOn(first.tabs, 'say').mockImplementation(() => undefined); // it hangs
    await vi.advanceTimersByTimeAsync(6000);
    expect(second.led).toBe(1);
    expect(second.tabs.isLeader).toBe(true);
    say.mockRestore();
    await vi.advanceTimersByTimeAsync(10);
    expect(first.tabs.isLeader).toBe(false);
  });
  it('leave a leader alone that says so every second, though the daemon is away', async () => {
    const first = new Tab('first');
    const second = new Tab('second');
    await vi.advanceTimersByTimeAsync(60_000);
    expect([first.tabs.isLeader, second.led]).toEqual([true, 0]);
  });
});
