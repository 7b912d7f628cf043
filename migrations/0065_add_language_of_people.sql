-- The language that somebody reads in, by its code. Absent: what their browser asks for.
ALTER TABLE people ADD COLUMN language TEXT CHECK (length(language) BETWEEN 2 AND 16);
