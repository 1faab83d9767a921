// What a view asks for waits until the stream has begun, so that nothing falls between the answer and the first event; but
// no longer than it takes a person to notice. A page without a stream (the report, unit tests) never waits.
let gate: Promise<void> | undefined;
let open: (() => void) | undefined;
const patienceMs = 400;

export function closeGate(): void {
  gate = new Promise((done) => {
    open = done;
    setTimeout(done, patienceMs);
  });
}

export function openGate(): void {
  open?.();
  gate = open = undefined;
}

export const streamBegun = (): Promise<void> => gate ?? Promise.resolve();
