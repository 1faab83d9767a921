// Parts of a browser that jsdom lacks and the page uses at its start, and the end of each test.
import { act, cleanup } from '@testing-library/preact';
import { afterEach } from 'vitest';

globalThis.matchMedia ??= ((query: string) => ({
  matches: false, media: query, addEventListener: () => undefined, removeEventListener: () => undefined,
})) as unknown as typeof matchMedia;
globalThis.ResizeObserver ??= class {
  observe() {}
  unobserve() {}
  disconnect() {}
};
HTMLDialogElement.prototype.showModal ??= function (this: HTMLDialogElement) { this.open = true; };
HTMLDialogElement.prototype.close ??= function (this: HTMLDialogElement) { this.open = false; };
globalThis.IntersectionObserver ??= class {
  observe() {}
  unobserve() {}
  disconnect() {}
} as unknown as typeof IntersectionObserver;

// Effects end with the test. Outside act Preact ends them one frame after the unmount, when a busy machine may have taken the document away.
afterEach(() => act(cleanup));
