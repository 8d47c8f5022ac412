import { defineConfig } from 'vitest/config';

export default defineConfig({ test: { include: ['tests/measure.ts'], testTimeout: 300_000 } });
