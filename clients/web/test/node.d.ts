// Types of Node that tests use, in place of all of them.
declare module 'node:fs' {
  export function readdirSync(folder: string, options: { withFileTypes: true }): { name: string; isDirectory(): boolean }[];
  export function readFileSync(name: string, encoding: 'utf8'): string;
}
