// What this browser remembers; a browser that refuses (private window, full) forgets at the end of the page.
function kept(of: () => Storage) {
  return {
    get(key: string): string | undefined {
      try {
        return of().getItem(`driftwise.${key}`) ?? undefined;
      } catch {
        return undefined;
      }
    },
    set(key: string, value: string): void {
      try {
        if (value === '') of().removeItem(`driftwise.${key}`);
        else of().setItem(`driftwise.${key}`, value);
      } catch {
        // remembered by the page alone
      }
    },
  };
}

export const remembered = kept(() => localStorage); // theme, name, panel heights
export const typed = kept(() => sessionStorage); // what a person typed, until the daemon took it
