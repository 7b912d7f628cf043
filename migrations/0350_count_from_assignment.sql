-- Whether only attempts since it was assigned count. Of an exercise they alone did until now, and whoever had mastered it before was late.
ALTER TABLE assignments ADD COLUMN since_only INTEGER NOT NULL DEFAULT 0 CHECK (since_only IN (0, 1));
