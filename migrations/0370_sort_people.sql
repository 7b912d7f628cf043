-- People are found and sorted by their names without marks and case, which SQL cannot compute: the service fills in both columns
-- when it starts, for whoever has none yet.
ALTER TABLE people ADD COLUMN sort_name TEXT NOT NULL DEFAULT '';
-- Whoever has no number comes first.
ALTER TABLE people ADD COLUMN sort_number TEXT GENERATED ALWAYS AS (coalesce(registrar_id, '')) VIRTUAL;
CREATE INDEX people_by_sort_name ON people (school_id, sort_name, id);
CREATE INDEX people_by_address ON people (school_id, email, id);
CREATE INDEX people_by_number ON people (school_id, sort_number, id);
CREATE INDEX people_unsorted ON people (id) WHERE sort_name = '' AND role <> 'guest';
