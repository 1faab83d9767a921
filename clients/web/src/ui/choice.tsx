// One of a few, kept in the address under `name`; the first is what stands there when nothing does.
import { query, setQuery } from '@/app/router';
import './choice.css';

export function SymbolChoice({ symbols, name = 'out', label = 'Output' }: { symbols: readonly string[]; name?: string; label?: string }) {
  const chosen = symbols.includes(query(name) ?? '') ? query(name) : symbols[0];
  if (symbols.length < 2) return null;
  return (
    <div class="choice" role="group" aria-label={label}>
      {symbols.map((symbol) => (
        <button type="button" key={symbol} aria-pressed={symbol === chosen ? 'true' : 'false'} onClick={() => setQuery({ [name]: symbol === symbols[0] ? undefined : symbol })}>{symbol}</button>
      ))}
    </div>
  );
}
