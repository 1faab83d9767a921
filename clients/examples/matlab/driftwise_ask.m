function reply = driftwise_ask(line, request)
% DRIFTWISE_ASK  One line out, one line back, without its end; see driftwise_target.
% A connection whose answer has not come (time-out, Ctrl-C) is dead for good: that answer may still come, and would be
% taken for the one to the next request. Connect again with driftwise_line.
  if strcmp(line.UserData, 'waiting')
    error('driftwise:CONNECTION_LOST', ...
          'an answer is missing on this connection, the next one may be another''s: connect again with driftwise_line');
  end
  line.UserData = 'waiting';
  write(line, uint8([char(request), char(10)]));
  bytes = uint8([]);
  while isempty(bytes) || bytes(end) ~= 10
    next = read(line, 1);
    if isempty(next)
      error('driftwise:NO_ANSWER', ...
            'the daemon closed the connection or did not answer in time: connect again with driftwise_line');
    end
    bytes(end + 1) = uint8(next); %#ok<AGROW>
  end
  line.UserData = '';
  reply = char(bytes(1:end - 1));
end
