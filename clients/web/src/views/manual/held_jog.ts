// A held button: the movement begins on press, a sign of life goes out every 100 ms, and it ends on release. Whatever else
// happens (the page goes away, the finger slips, the tab is hidden) the signs end, and with them the movement: the daemon
// stops the axis 300 ms after the last one.
import { Code, ConnectError } from '@connectrpc/connect';
import { api } from '@/api/client';
import { failureOf } from '@/api/errors';
import type { Jog } from '@/api/gen/driftwise/v1/commissioning_service_pb';
import { cell } from '@/live/state';
import type { HoldAnswer } from '@/parts/hold_question';
import { commissioningApi } from './api';

export const signEvery_ms = 100;
export const answerWithin_ms = 1000;
const renewEvery = 200; // signs: 20 s of a lease of 60

export interface JogWish {
  channel: string;
  stepMm: number;
  answer: HoldAnswer | undefined;
}

const leaseSeconds = () => BigInt(Math.min(3600, Math.max(1, Math.round(60 * (cell.value?.speed || 1)))));
const within = { timeoutMs: answerWithin_ms };
const restWithin = { timeoutMs: 10_000 }; // EndJog answers when the axis rests
const takeLease = async (token: string) =>
  (await api.cell().takeLease({ leaseDuration: { seconds: leaseSeconds(), nanos: 0 }, token }, within)).lease?.token ?? '';

// A deadline of the page as a sentence: the library's own one does not say what the axis does. The daemon's have a reason.
const inWords = (error: unknown, resting: boolean): unknown => {
  const { code, reason } = failureOf(error);
  return code === Code.DeadlineExceeded && reason === ''
    ? new ConnectError(`The daemon did not answer within ${resting ? 10 : 1} s. It stops the axis by itself 300 ms after the last sign of the held button: look at its position`, Code.DeadlineExceeded)
    : error;
};

export class HeldJog {
  released = false;
  private token = '';
  private jogId: bigint | undefined;
  private resting = false; // its end is asked for, and awaited

  constructor(private readonly onState: (jog: Jog) => void) {}

  // Returns when the movement is over; throws what the daemon refused, and when it did not answer in time.
  async run(wish: JogWish): Promise<Jog | undefined> {
    return this.carry(wish).catch((error) => {
      throw inWords(error, this.resting);
    });
  }

  private async carry(wish: JogWish): Promise<Jog | undefined> {
    this.token = await takeLease('');
    try {
      if (this.released) return undefined; // before anything moved
      const { jog } = await commissioningApi().beginJog({ leaseToken: this.token, channel: wish.channel, stepMm: wish.stepMm, held: true, ...(wish.answer && { answer: wish.answer }) }, within);
      let state = jog!;
      this.jogId = state.id;
      for (let signs = 1; !state.over && !this.released; signs++) {
        this.onState(state);
        await new Promise((done) => setTimeout(done, signEvery_ms));
        if (this.released) break;
        if (signs % renewEvery === 0) await takeLease(this.token);
        state = (await commissioningApi().holdJog({ jogId: state.id, leaseToken: this.token }, within)).jog!;
      }
      if (!state.over) {
        this.resting = true;
        state = (await commissioningApi().endJog({ jogId: state.id, leaseToken: this.token }, restWithin)).jog!;
      }
      this.onState(state);
      return state;
    } finally {
      void api.cell().giveUpLease({ token: this.token }).catch(() => undefined); // it runs out by itself
    }
  }

  // The stop is asked for at once, beside a sign that may be under way.
  release(): void {
    if (this.released) return;
    this.released = true;
    if (this.jogId !== undefined) void commissioningApi().endJog({ jogId: this.jogId, leaseToken: this.token }, within).catch(() => undefined);
  }
}
