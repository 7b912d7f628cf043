-- Who signs certificates and transcripts on paper. Schools of before have named nobody: an empty name.
ALTER TABLE schools ADD COLUMN signatory_name TEXT NOT NULL DEFAULT '';
ALTER TABLE schools ADD COLUMN signatory_function TEXT NOT NULL DEFAULT '';
