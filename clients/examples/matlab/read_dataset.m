function table = read_dataset(file)
% READ_DATASET  A dataset of Driftwise (docs/formats.md) in MATLAB or GNU Octave.
%   t = read_dataset("campaign.csv");        one field per column, named as in the file
%   cal = t.in_use & strcmp(t.set, "calibration");
%   A = [ones(sum(cal), 1), t.x_mm(cal), t.t05_degC(cal)];
%   coefficients = A \ t.q1_mm(cal)
% t.in_use is true on the rows that Driftwise fits. False: passages (the zero of a datum, a return of the run's own;
% these may have no pose, and one NaN makes all coefficients NaN), and what is excluded or suspect.
% Columns are numbers (NaN: not measured), but set, run and datum, which are cells of text.
% Lines "# key: value" at the top become fields of t.metadata.
  text = fileread(file);
  lines = strsplit(strrep(text, sprintf("\r"), ''), sprintf("\n"), 'CollapseDelimiters', false);
  table = struct();
  table.metadata = struct();
  row = 1;
  while row <= numel(lines) && ~isempty(lines{row}) && lines{row}(1) == '#'
    parts = regexp(lines{row}, '^#\s*([^:]+):\s*(.*)$', 'tokens', 'once');
    if numel(parts) == 2
      table.metadata.(regexprep(parts{1}, '[^A-Za-z0-9_]', '_')) = parts{2};
    end
    row = row + 1;
  end
  names = strsplit(lines{row}, ',');
  body = lines(row + 1:end);
  body = body(~cellfun(@isempty, body));
  fields = cell(numel(body), numel(names));
  for i = 1:numel(body)
    one = strsplit(body{i}, ',', 'CollapseDelimiters', false);
    if numel(one) ~= numel(names)
      error('read_dataset:row', '%s: row %d has %d fields, the header names %d', file, i, numel(one), numel(names));
    end
    fields(i, :) = one;
  end
  for j = 1:numel(names)
    if any(strcmp(names{j}, {'set', 'run', 'datum'}))
      table.(names{j}) = fields(:, j);
    else
      table.(names{j}) = str2double(fields(:, j));  % an empty field becomes NaN
    end
  end
  table.in_use = true(size(fields, 1), 1);
  for mark = {'excluded', 'suspect', 'passage'}
    if isfield(table, mark{1})
      table.in_use = table.in_use & table.(mark{1}) ~= 1;
    end
  end
end
