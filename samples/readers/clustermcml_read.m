function data = clustermcml_read(path)
  % The result in a file, .mco or .h5, for GNU Octave and MATLAB.
  %
  %   data = clustermcml_read('thick.mco');
  %   printf('Rd = %g +- %g\n', data.Rd, data.Rd_se)
  %   errorbar(data.r, data.Rd_r, data.Rd_r_se)
  %
  % Fields have the names of `clustermcml help output`; NAME_se is the standard error of NAME. Profiles are columns, grids have
  % the axes in the order of their names: A_rz(i, k) belongs to data.r(i) and data.z(k), Rd_xya(iy, ix, ia) to data.y, x, alpha.
  % Lengths are in cm. Files of original MCML can be read, too; they have no errors.
  % An .mco has the arrays of original MCML and their errors; all else is in the .h5 of the run.
  % SPDX-License-Identifier: MIT
  if exist(path, 'file') ~= 2
    error('clustermcml_read: path = %s (expected a file that is there)', path);
  end
  [~, ~, ending] = fileparts(path);
  switch lower(ending)
    case '.mco', data = read_mco(path);
    case '.h5', data = read_h5(path);
    otherwise, error('clustermcml_read: path = %s (expected a name that ends in .mco or .h5)', path);
  end
end

function data = read_mco(path)
  text = fileread(path);
  if ~strncmp(text, 'A1', 2), error('%s: not an .mco file (expected A1 at its beginning)', path); end
  sections = sections_of(text);
  if ~isfield(sections, 'Tt_ra'), error('%s: not a whole .mco file (expected Tt_ra in it)', path); end
  given = sections.InParm; % photons, dz dr, nz nr na, layers, n above, n mua mus g d of each, n below
  data = struct('photons', given(1));
  data.z = ((1:given(4))' - 0.5) * given(2);
  data.r = ((1:given(5))' - 0.5) * given(3);
  data.alpha = ((1:given(6))' - 0.5) * pi / 2 / given(6);
  data.layer = (1:given(7))';
  media = reshape(given(9:8 + 5 * given(7)), 5, [])';
  names = {'n', 'mua', 'mus', 'g', 'd'};
  for i = 1:5, data.(['layer_' names{i}]) = media(:, i); end
  totals = {'Rsp', 'Rd', 'A', 'Tt'};
  for i = 1:4, data.(totals{i}) = sections.RAT(i); end
  if isfield(sections, 'se_RAT')
    for i = 1:4, data.([totals{i} '_se']) = sections.se_RAT(i); end
  end
  data = add_arrays(data, sections);
end

function data = add_arrays(data, sections)
  % The rest; in the file the last axis of a grid runs first. se_NAME becomes NAME_se.
  grids = struct('A_rz', numel(data.z), 'Rd_ra', numel(data.alpha), 'Tt_ra', numel(data.alpha));
  names = setdiff(fieldnames(sections), {'InParm', 'RAT', 'se_RAT'});
  for i = 1:numel(names)
    name = names{i};
    values = sections.(name);
    if isfield(grids, name), values = reshape(values, grids.(name), [])'; end
    if strncmp(name, 'se_', 3), name = [name(4:end) '_se']; end
    data.(name) = values;
  end
end

function sections = sections_of(text)
  % Every section as a column of numbers; of InParm those behind the line of the output's name.
  lines = strsplit(text, "\n");
  sections = struct();
  key = '';
  named = false;
  for i = 2:numel(lines)
    line = strtrim(regexprep(lines{i}, '#.*', ''));
    if isempty(line), continue, end
    if named % of the output; it may be anything
      named = false;
    elseif ~isempty(regexp(line, '^[A-Za-z]\w*$', 'once'))
      key = line;
      parts.(key) = {};
      named = strcmp(key, 'InParm');
    elseif ~isempty(key)
      parts.(key){end + 1} = line;
    end
  end
  keys = fieldnames(parts);
  for i = 1:numel(keys), sections.(keys{i}) = sscanf(strjoin(parts.(keys{i}), ' '), '%f'); end
end

function data = read_h5(path)
  if exist('OCTAVE_VERSION', 'builtin')
    data = load('-hdf5', path, '[!c]*'); % but the group `call`, at which it would stop; axes come last first, as in MATLAB
  else
    info = h5info(path);
    for i = 1:numel(info.Datasets)
      name = info.Datasets(i).Name;
      data.(name) = h5read(path, ['/' name]);
    end
  end
  if ~isfield(data, 'Rd'), error('%s: not a result (expected the array Rd in it)', path); end
  names = fieldnames(data);
  for i = 1:numel(names)
    values = data.(names{i});
    bins = bins_of(names{i}, data);
    if ~isnumeric(values), continue, end
    if ~isempty(bins)
      data.(names{i}) = permute(reshape(double(values), fliplr(bins)), numel(bins):-1:1);
    elseif isvector(values)
      data.(names{i}) = double(values(:));
    else
      data.(names{i}) = permute(double(values), ndims(values):-1:1);
    end
  end
end

function bins = bins_of(name, data)
  % Numbers of bins of a grid, whose name ends in those of its axes: an axis of one bin cannot be told from the size of the array.
  bins = [];
  axes_of = struct('rz', {{'r', 'z'}}, 'ra', {{'r', 'alpha'}}, 'xy', {{'y', 'x'}}, 'xya', {{'y', 'x', 'alpha'}}, ...
                   'xyz', {{'z_volume', 'y', 'x'}});
  ending = regexp(regexprep(name, '_se$', ''), '_(rz|ra|xy|xya|xyz)$', 'tokens', 'once');
  if isempty(ending), return, end
  bins = cellfun(@(axis) numel(data.(axis)), axes_of.(ending{1}));
end
