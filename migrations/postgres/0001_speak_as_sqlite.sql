-- What SQLite has of its own and statements of the storage use, by SQLite's name and with its meaning, as far as they use it: so that
-- most statements are the same for both engines. An id is 16 bytes to SQLite and a UUID here.

-- A truth value compared with 0 or 1: SQLite keeps it as one of the two.
CREATE FUNCTION truth_is(truth BOOLEAN, number INTEGER) RETURNS BOOLEAN LANGUAGE SQL IMMUTABLE
RETURN truth = (number <> 0);
CREATE FUNCTION truth_is_not(truth BOOLEAN, number INTEGER) RETURNS BOOLEAN LANGUAGE SQL IMMUTABLE
RETURN truth <> (number <> 0);
CREATE OPERATOR = (LEFTARG = BOOLEAN, RIGHTARG = INTEGER, FUNCTION = truth_is, NEGATOR = <>);
CREATE OPERATOR <> (LEFTARG = BOOLEAN, RIGHTARG = INTEGER, FUNCTION = truth_is_not, NEGATOR = =);

-- How many of them are true; NULL of none, as every sum.
CREATE FUNCTION add_truth(so_far BIGINT, truth BOOLEAN) RETURNS BIGINT LANGUAGE SQL IMMUTABLE
RETURN CASE WHEN truth IS NULL THEN so_far ELSE coalesce(so_far, 0) + truth::INTEGER END;
CREATE AGGREGATE sum (BOOLEAN) (SFUNC = add_truth, STYPE = BIGINT);

-- Of two or three numbers; NULL where one of them is.
CREATE FUNCTION max(a BIGINT, b BIGINT) RETURNS BIGINT LANGUAGE SQL IMMUTABLE
RETURN CASE WHEN a >= b THEN a WHEN a < b THEN b END;
CREATE FUNCTION max(a BIGINT, b BIGINT, c BIGINT) RETURNS BIGINT LANGUAGE SQL IMMUTABLE
RETURN max(max(a, b), c);
CREATE FUNCTION min(a BIGINT, b BIGINT) RETURNS BIGINT LANGUAGE SQL IMMUTABLE
RETURN CASE WHEN a <= b THEN a WHEN a > b THEN b END;

CREATE FUNCTION iif(condition BOOLEAN, yes ANYCOMPATIBLE, no ANYCOMPATIBLE) RETURNS ANYCOMPATIBLE LANGUAGE SQL IMMUTABLE
AS $$ SELECT CASE WHEN condition THEN yes ELSE no END $$;

CREATE FUNCTION instr(text TEXT, part TEXT) RETURNS INTEGER LANGUAGE SQL IMMUTABLE
RETURN strpos(text, part);

-- An id in capital hexadecimal digits, and back: NULL of what is no id.
CREATE FUNCTION hex(id UUID) RETURNS TEXT LANGUAGE SQL IMMUTABLE
RETURN upper(replace(id::TEXT, '-', ''));
CREATE FUNCTION unhex(digits TEXT) RETURNS UUID LANGUAGE SQL IMMUTABLE
RETURN CASE WHEN digits ~ '^[0-9A-Fa-f]{32}$' THEN digits::UUID END;
CREATE FUNCTION unhex(digits TEXT, ignored TEXT) RETURNS UUID LANGUAGE SQL IMMUTABLE
RETURN unhex(replace(digits, ignored, ''));

-- What tells SQLite's planner something, and changes nothing: that few rows are so, and that an index is of no use.
CREATE FUNCTION unlikely(condition BOOLEAN) RETURNS BOOLEAN LANGUAGE SQL IMMUTABLE
RETURN condition;
CREATE FUNCTION id_itself(id UUID) RETURNS UUID LANGUAGE SQL IMMUTABLE
RETURN id;
CREATE OPERATOR + (RIGHTARG = UUID, FUNCTION = id_itself);

-- The id of nothing, and one by chance.
CREATE FUNCTION zeroblob(length INTEGER) RETURNS UUID LANGUAGE SQL IMMUTABLE
RETURN CASE length WHEN 16 THEN '00000000-0000-0000-0000-000000000000'::UUID END;
CREATE FUNCTION randomblob(length INTEGER) RETURNS UUID LANGUAGE SQL VOLATILE
RETURN CASE length WHEN 16 THEN gen_random_uuid() END;

-- A number in the digits that tell it from every other, or as those of an id.
CREATE FUNCTION printf(format TEXT, number DOUBLE PRECISION) RETURNS TEXT LANGUAGE SQL IMMUTABLE
RETURN CASE format WHEN '%!.17g' THEN number::TEXT END;
CREATE FUNCTION printf(format TEXT, number BIGINT) RETURNS TEXT LANGUAGE SQL IMMUTABLE
RETURN CASE format WHEN '%032x' THEN lpad(to_hex(number), 32, '0') END;

-- A moment, in s since 1970 UTC.
CREATE FUNCTION strftime(format TEXT, moment BIGINT, unit TEXT) RETURNS TEXT LANGUAGE SQL STABLE
RETURN to_char(to_timestamp(moment) AT TIME ZONE 'UTC',
    CASE format WHEN '%Y' THEN 'YYYY' WHEN '%m' THEN 'MM' WHEN '%Y-%m-%dT%H:%M:%S' THEN 'YYYY-MM-DD"T"HH24:MI:SS' END);

-- What a JSON array holds, each value as text.
CREATE FUNCTION json_each(list TEXT) RETURNS TABLE (key BIGINT, value TEXT) LANGUAGE SQL IMMUTABLE
AS $$ SELECT e.place - 1, e.value FROM json_array_elements_text(list::JSON) WITH ORDINALITY AS e (value, place) $$;

-- What JSON holds at a path, as text: '$.a.b' or 'a'.
CREATE FUNCTION text_at(json TEXT, path TEXT) RETURNS TEXT LANGUAGE SQL IMMUTABLE
RETURN json::JSON #>> string_to_array(regexp_replace(path, '^\$\.', ''), '.');
CREATE OPERATOR ->> (LEFTARG = TEXT, RIGHTARG = TEXT, FUNCTION = text_at);

-- The first value of the last of an array's arrays.
CREATE FUNCTION json_extract(json TEXT, path TEXT) RETURNS TEXT LANGUAGE SQL IMMUTABLE
RETURN CASE path WHEN '$[#-1][0]' THEN json::JSON -> -1 ->> 0 END;

-- JSON arrays of what stands in the statements, and of what an aggregate finds; an array of nothing is '[]'.
CREATE FUNCTION json_array(a BIGINT, b TEXT, c TEXT) RETURNS JSON LANGUAGE SQL IMMUTABLE
RETURN json_build_array(a, b, c);
CREATE FUNCTION json_array(a TEXT, b BIGINT, c TEXT, d TEXT) RETURNS JSON LANGUAGE SQL IMMUTABLE
RETURN json_build_array(a, b, c, d);
CREATE FUNCTION json_array(a BIGINT, b TEXT, c BIGINT, d DOUBLE PRECISION) RETURNS JSON LANGUAGE SQL IMMUTABLE
RETURN json_build_array(a, b, c, d);
CREATE FUNCTION json_array(a TEXT, b BIGINT, c DOUBLE PRECISION, d JSON, e TEXT) RETURNS JSON LANGUAGE SQL IMMUTABLE
RETURN json_build_array(a, b, c, d, e);
CREATE FUNCTION json_of(list JSON[]) RETURNS TEXT LANGUAGE SQL IMMUTABLE
RETURN array_to_json(list)::TEXT;
CREATE AGGREGATE json_group_array (JSON) (SFUNC = array_append, STYPE = JSON[], FINALFUNC = json_of, INITCOND = '{}');

-- The size of the database, in pages and their bytes.
CREATE VIEW pragma_page_size AS SELECT current_setting('block_size')::BIGINT AS page_size;
CREATE VIEW pragma_page_count AS
SELECT pg_database_size(current_database()) / page_size AS page_count FROM pragma_page_size;
