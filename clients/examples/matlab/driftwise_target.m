function answer = driftwise_target(line, varargin)
% DRIFTWISE_TARGET  Compensated motor coordinates over the text line (docs/target-line.md), MATLAB or GNU Octave.
%   line = driftwise_line("127.0.0.1", 50052);                    connects
%   line = driftwise_line("192.168.7.1", 50053, "dwt_...");       ... and says who asks
%   a = driftwise_target(line, "x_mm", 1.5, "force_N", 0);
%   a.q1_mm, a.u90_nm, a.valid_until, a.flags                     flags: "-" for none
% A refusal is an error with the daemon's reason: err.identifier is "driftwise:NO_MODEL".
% The line is plain: over TLS let stunnel stand between (docs/target-line.md).
  if mod(numel(varargin), 2) ~= 0
    error('driftwise:BAD_NUMBER', 'found %d arguments after the line, expected names and values in pairs', numel(varargin));
  end
  request = "TARGET u=1";
  for i = 1:2:numel(varargin)
    value = varargin{i + 1};
    % The digits of an array would run together: [0.5 1] reads 0.51, a valid pose.
    if ~(isnumeric(value) && isreal(value) && isscalar(value))
      error('driftwise:BAD_NUMBER', '%s: found %s of size %s, expected one real number', char(varargin{i}), class(value), ...
            mat2str(size(value)));
    end
    request = [char(request), ' ', char(varargin{i}), '=', sprintf('%.17g', value)];
  end
  reply = driftwise_ask(line, request);
  words = strsplit(reply, ' ');
  if ~strcmp(words{1}, 'OK')
    error(['driftwise:', regexprep(words{2}, '\(.*$', '')], '%s', reply);
  end
  answer = struct();
  for i = 2:numel(words)
    [name, value] = strtok(words{i}, '=');
    value = value(2:end);
    number = str2double(value);
    if isnan(number)
      answer.(name) = value;
    else
      answer.(name) = number;
    end
  end
end
