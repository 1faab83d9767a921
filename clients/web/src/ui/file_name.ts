// "Drift of the zero, q1" -> "drift-of-the-zero-q1"
export const fileName = (words: string): string =>
  words.toLowerCase().normalize('NFKD').replace(/[^a-z0-9]+/g, '-').replace(/^-+|-+$/g, '').slice(0, 80);
