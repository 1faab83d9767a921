// What tests use of Node, in place of all its types.
declare module 'node:fs' {
  export function readdirSync(folder: string, options: { withFileTypes: true }): { name: string; isDirectory(): boolean }[];
  export function readFileSync(name: string, encoding: 'utf8'): string;
}
