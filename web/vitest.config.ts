import { defineConfig } from 'vitest/config';

// One browser on few cores: what is awaited may take a while.
export default defineConfig({ test: { include: ['tests/*.test.ts'], fileParallelism: false, testTimeout: 120_000, hookTimeout: 180_000 } });
