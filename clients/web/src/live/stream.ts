// The page's one stream of events.
export function startStream(): void {}
